//! Ringing bodies for tests: a triangle whose nodes move alike, with transfers of any coefficients.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::contact::{BodyPulse, ForceProfile, HertzRange, ImpactPulse, PoseHistory};
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::material::{Damping, presets};
use clangor_core::medium::Medium;
use clangor_core::pose::{Pose, Track};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_core::synthesis::modal::{ModalSettings, ModalSource};
use num_complex::Complex64;

/// R [m].
pub(crate) const RADIUS: f64 = 0.1;
/// Impulse of the impacts [N s].
pub(crate) const IMPULSE: f64 = 0.02;

/// A mode whose every node moves by `shape`.
pub(crate) fn mode(frequency: f64, shape: DVec3, coefficients: Vec<Complex64>) -> ModalMode {
    let order = coefficients.len().isqrt() - 1;
    let transfer = Some(ModalTransfer { order, coefficients });
    ModalMode { frequency, mesh_error: 0.0, support_damping: 0.0, shape: vec![shape; 6], transfer }
}

/// A source of these modes.
pub(crate) fn source(modes: Vec<ModalMode>, damping: &Damping, settings: &ModalSettings) -> Arc<ModalSource> {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|x| 0.1 * x);
    let middles = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| 0.5 * (corners[a] + corners[b]));
    let nodes = corners.into_iter().chain(middles).collect();
    let model = ModalModel {
        radius: RADIUS,
        medium: Medium::AIR,
        density: 2700.0,
        max_frequency: 20_000.0,
        statistical_above: None,
        surface: ModalSurface { nodes, triangles: vec![[0, 1, 2, 3, 4, 5]] },
        modes,
    };
    Arc::new(ModalSource::new(Arc::new(model), damping, settings).expect("a good model"))
}

/// A ball with a prescribed motion.
pub(crate) fn body(motion: Motion) -> Body {
    let pose = match &motion {
        Motion::Keyframed(track) => track.sample(0.0).0,
        _ => Pose::IDENTITY,
    };
    let surface = Surface::Sphere { radius: RADIUS };
    Body::new("bell", presets::CERAMIC.material(), surface, 1.0, DMat3::IDENTITY)
        .at(pose)
        .with_motion(motion)
        .with_edge_radius(1e-3)
}

/// Poses of one body with a prescribed motion.
pub(crate) fn poses(motion: Motion) -> PoseHistory {
    PoseHistory::try_new(&[body(motion)], &[]).expect("a history")
}

/// A body that stays at the origin.
pub(crate) fn still() -> PoseHistory {
    poses(Motion::Keyframed(Track::fixed(Pose::IDENTITY)))
}

/// An impact along z on body 0, which is A.
pub(crate) fn impact(onset: f64, duration: f64, pose: Pose) -> ImpactPulse {
    let impulse = IMPULSE * DVec3::Z;
    let share = BodyPulse {
        body: BodyId(0),
        pose,
        impulse,
        velocity_change: impulse,
        angular_impulse: DVec3::ZERO,
        angular_velocity_change: DVec3::ZERO,
        transit_ratio: 2.0,
        modal_gain: 1.0,
    };
    ImpactPulse {
        impact_id: 0,
        time: onset,
        onset,
        duration,
        shape: ForceProfile::HalfSine.into(),
        speed: 1.0,
        effective_mass: 1.0,
        radius: 1.0,
        range: HertzRange::Within,
        point: DVec3::ZERO,
        normal: DVec3::Z,
        velocity_before: None,
        pair: [BodyId(0), BodyId::WORLD],
        bodies: [Some(share), None],
        points: vec![(pose.world_from_body(DVec3::new(0.03, 0.02, 0.0)), impulse)],
        modal_energy_ratio: 0.0,
    }
}
