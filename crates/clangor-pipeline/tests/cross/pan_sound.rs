//! A click through the published representation sounds as the same click through our own, within the
//! published error.

use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_bake::acceleration::BakeOptions;
use clangor_bake::reference::PanForm;
use clangor_core::body::{BodyId, Surface};
use clangor_core::contact::ForceProfile;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::reference::PanSource;
use clangor_core::reference::pan_file::PanFile;
use clangor_core::shape::Shape;
use clangor_core::sound_model::acceleration::model_evaluator::ModelEvaluator;
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::{
    AccelerationPulse, FieldSource, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource,
};
use clangor_pipeline::stages::sound_models::{
    AccelerationBake, SoundModelRequest, bake_model, pan_representation,
};

/// Clicks in three directions, as two receivers hear them above a floor.
fn render(source: &SoundSource, profile: ForceProfile, floor: Floor) -> (Vec<Vec<f64>>, f64) {
    let listener = Listener {
        receivers: vec![DVec3::ZERO, DVec3::new(0.1, 0.3, -0.2)],
        ..Listener::fixed("listener", DVec3::new(0.25, 1.1, 0.35))
    };
    let settings = RenderSettings::default().with_floor(floor);
    let mut renderer = Renderer::new(&listener, &settings).unwrap();
    for i in 0..3 {
        let turn = DVec3::new(0.3, -0.7, 0.2) * f64::from(i);
        renderer
            .push(&AccelerationPulse {
                body: BodyId(0),
                time: 0.01 * f64::from(i),
                duration: 200e-6,
                shape: profile.into(),
                centre: DVec3::Y,
                orientation: DQuat::from_scaled_axis(turn),
                velocity_change: DVec3::new(1.0, -0.4, 0.7),
                angular_velocity_change: DVec3::new(20.0, 10.0, -30.0),
                source: source.clone(),
            })
            .unwrap();
    }
    let mut signal = OverlapAdd::new(2, 0);
    renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
    let energy = signal.energies()[&BodyId(0)];
    (signal.take_until(2400), energy)
}

fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = || a.iter().flatten().zip(b.iter().flatten());
    (pairs().map(|(a, b)| (a - b).powi(2)).sum::<f64>() / pairs().map(|(_, b)| b * b).sum::<f64>()).sqrt()
}

#[test]
fn both_published_forms_sound_as_ours() {
    let (surface, mass) = Shape::parse("die:0.03x0.004").unwrap().surface().unwrap();
    let options = BakeOptions::new(std::f64::consts::TAU * 20_000.0 / 343.2, 5e-3);
    let request = SoundModelRequest::new("die", &surface, mass, AccelerationBake(options)).unwrap();
    let model = bake_model(&request, &mut |_| ControlFlow::Continue(())).unwrap();
    let surface: Arc<Surface> = Arc::new(surface);
    let own = ModelEvaluator::try_new(&model.acceleration).unwrap();
    let own = FieldSource::new(own.field, None, own.radius, DQuat::IDENTITY, Arc::clone(&surface));
    let own = SoundSource::Field(Arc::new(own));
    // The table of docs/theory/proxy.md has PAN at 12 %, PROXY at 6 %. Seen here: PAN 11.5 %, nearly all of
    // it a sound that is too quiet, so that a fifth of its energy lacks.
    for (form, most) in
        [(PanForm::Angles { rows: 5, columns: 10 }, 0.2), (PanForm::Octant { tolerance: 0.01 }, 0.1)]
    {
        let file = PanFile::decode(&pan_representation(&model, form).unwrap().encode().unwrap()).unwrap();
        let published = PanSource::new(Arc::new(file.model), Arc::clone(&surface));
        let published = SoundSource::Reference(Arc::new(published));
        for (profile, floor) in
            [(ForceProfile::HalfSine, Floor::None), (ForceProfile::Gaussian, Floor::Rigid { height: 0.0 })]
        {
            let ((a, a_energy), (b, b_energy)) =
                (render(&published, profile, floor), render(&own, profile, floor));
            let error = difference(&a, &b);
            println!("{form:?} {profile:?}: {error:.4}, energy {:.4}", a_energy / b_energy);
            assert!(error < most, "{form:?} {profile:?}: {error}");
            assert!((a_energy / b_energy - 1.0).abs() < 2.0 * most, "{form:?} {profile:?}");
        }
    }
}

#[test]
fn an_octant_is_not_enough_for_a_stone() {
    let (surface, mass) = Shape::parse("rock:3x0.01").unwrap().surface().unwrap();
    let options = BakeOptions::new(100.0, 0.05);
    let request = SoundModelRequest::new("rock", &surface, mass, AccelerationBake(options)).unwrap();
    let model = bake_model(&request, &mut |_| ControlFlow::Continue(())).unwrap();
    let error = pan_representation(&model, PanForm::Octant { tolerance: 0.01 }).unwrap_err().to_string();
    assert!(error.contains("three planes of symmetry"), "{error}");
}
