//! Prints `web/src/event-layout.js`, the layout of the numbers that the module and the page exchange.

fn main() {
    print!("{}", clangor_web::layout::javascript());
}
