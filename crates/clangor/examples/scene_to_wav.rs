//! From a scene to a WAV file: `cargo run --release -p clangor --example scene_to_wav`.
fn main() -> Result<(), clangor::Error> {
    let mut session = clangor::Session::open("scenes/ball-drop.toml")?;
    let sound = session.render("ball-drop.wav")?;
    println!("{} samples, peak {:.2} Pa", sound.frames, sound.peak);
    Ok(())
}
