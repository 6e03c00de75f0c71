//! A ceramic bowl is struck on its rim: `cargo run --release -p clangor --example struck_bowl`.
fn main() -> Result<(), clangor::Error> {
    let bowl = clangor::StruckBody::shape("bowl", "ceramic")?;
    let sound = clangor::Strike::new(bowl) // on top, which is the rim
        .impulse([0.0, -0.01, 0.0]) // N s
        .listener([0.5, 0.3, 0.5]) // m from the centre of mass
        .render()?;
    let peak = sound.pressures.iter().fold(0.0_f64, |peak, p| peak.max(p.abs()));
    println!("{} samples, peak {peak:.2} Pa", sound.pressures.len());
    Ok(())
}
