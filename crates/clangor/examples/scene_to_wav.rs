//! A scene in, a WAV file out.

fn main() -> Result<(), clangor::Error> {
    let mut session = clangor::Session::open("scenes/ball-drop.toml")?;
    let sound = session.render("ball-drop.wav")?;
    println!("{} samples, peak {} Pa", sound.frames, sound.peak);
    Ok(())
}
