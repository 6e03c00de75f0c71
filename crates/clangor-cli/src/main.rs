//! The program `clangor`.

fn main() {}
