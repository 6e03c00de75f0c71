//! Balls and cubes for tests of contact and sound.

use std::f64::consts::PI;
use std::sync::Arc;

use clangor_core::body::{Body, MeshSurface, Surface};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::material::{Damping, Material};
use clangor_core::synthesis::SoundSource;
use clangor_core::synthesis::strike::{Strike, StrikeError, StrikeSound};

/// A material with only what contact needs.
pub(crate) fn material(name: &str, density: f64, youngs_modulus: f64, poisson_ratio: f64) -> Material {
    Material {
        name: name.into(),
        density,
        youngs_modulus,
        poisson_ratio,
        restitution: 1.0,
        restitution_speed: None,
        rigid_restitution: None,
        yield_strength: None,
        friction: 0.0,
        rolling_loss: 0.0,
        damping: Damping::LossFactor(1e-3),
        tensile_strength: None,
        fracture_energy: None,
        source: "test".into(),
    }
}

/// A free ball at rest.
pub(crate) fn ball(material: Material, radius: f64, position: DVec3) -> Body {
    let mass = material.density * 4.0 / 3.0 * PI * radius.powi(3);
    let inertia = DMat3::from_diagonal(DVec3::splat(0.4 * mass * radius * radius));
    Body::new("ball", material, Surface::Sphere { radius }, mass, inertia).at(position)
}

/// A free ball of the material that \[PAN\] Table 1 prints for its ball bearing.
#[allow(dead_code, reason = "not every test that shares this file needs it")]
pub(crate) fn pan_steel_ball(radius: f64, position: DVec3) -> Body {
    ball(material("pan-steel", 8940.0, 123.4e9, 0.34), radius, position)
}

/// A free cube about the origin, of the same material.
#[allow(dead_code, reason = "not every test that shares this file needs it")]
pub(crate) fn cube(edge: f64) -> Body {
    let ball = pan_steel_ball(0.01, DVec3::ZERO);
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 0.5 * edge } else { -0.5 * edge };
        DVec3::new(side(0), side(1), side(2))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let mesh = TriMesh { vertices: (0..8).map(corner).collect(), triangles };
    let (surface, mass) = MeshSurface::try_new(mesh, Vec::new()).unwrap();
    let density = ball.material.density;
    Body {
        surface: Arc::new(Surface::Mesh(surface)),
        mass: density * mass.volume,
        inertia: mass.inertia * density,
        ..ball
    }
}

/// The impact to a body that sounds as the sphere of its volume.
#[allow(dead_code, reason = "not every test that shares this file needs it")]
pub(crate) fn strike(body: &Body, impact: &Strike) -> Result<StrikeSound, StrikeError> {
    clangor_core::synthesis::strike::strike(
        body,
        &SoundSource::equal_volume_sphere(&body.surface),
        None,
        impact,
    )
}
