//! Two steel spheres collide at 1 m/s: `cargo run --release -p clangor --example real_time`.
use clangor::realtime::{EngineSettings, ImpactEvent, ImpactTarget, SoundingObject, engine};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = EngineSettings::default();
    let (mut controller, mut engine) = engine(&settings)?; // the engine moves to the audio thread
    controller.put(0, Some(SoundingObject::sphere(0.02, &settings)))?;
    controller.put(1, Some(SoundingObject::sphere(0.03, &settings)))?;
    controller.place_listener([0.0, 0.2, 0.5].into(), [1.0, 0.0, 0.0].into())?;
    for (slot, centre, velocity_change) in [(0, -0.02, -1.5), (1, 0.03, 0.45)] {
        let impact = ImpactEvent::new(ImpactTarget::Object { slot }, 0.001, 90e-6)
            .at([centre, 0.0, 0.0].into())
            .with_velocity_change([velocity_change, 0.0, 0.0].into());
        controller.send(impact)?;
    }
    let mut peak = 0.0_f64;
    for _block in 0..8 {
        let channels = engine.render(128); // pressure [Pa] at the left and the right ear
        peak = channels.iter().flatten().fold(peak, |peak, p| peak.max(p.abs()));
    }
    println!("peak {peak:.2} Pa");
    Ok(())
}
