//! Mass properties and curvature of meshes against closed forms.

use clangor_core::geometry::curvature::mean_curvature;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::shape::Shape;
use std::f64::consts::PI;

use super::{Check, Extent, Outcome, Validation};

const SECTION: &str = "Geometry";

pub(super) fn run(_extent: Extent, table: &mut Validation) -> Outcome {
    // Shape, volume and moment about y of unit density, bar: flat faces are exact, curved ones inscribed.
    let (major, minor) = (0.012_f64, 0.0025_f64);
    let torus = 2.0 * PI * PI * major * minor * minor;
    let sphere = 4.0 / 3.0 * PI * 0.05_f64.powi(3);
    let cases = [
        ("box:0.1x0.2x0.05", 0.001, 0.001 * (0.1 * 0.1 + 0.05 * 0.05) / 12.0, 1e-12),
        ("sphere:0.05@0.001", sphere, 0.4 * sphere * 0.05 * 0.05, 1e-3),
        ("torus:0.012x0.0025@0.0002", torus, torus * (major * major + 0.75 * minor * minor), 5e-3),
    ];
    for (text, volume, about_y, bar) in cases {
        let mesh = Shape::parse(text)?.mesh();
        let mass = MassProperties::of(&mesh)?;
        let errors = [mass.volume / volume - 1.0, mass.inertia.y_axis.y / about_y - 1.0];
        table.checks.push(Check {
            section: SECTION,
            quantity: format!(
                "volume and inertia of the mesh of `{text}`, {} triangles",
                mesh.triangles.len()
            ),
            reference: "closed form of the smooth body",
            error: errors.iter().fold(0.0, |m, e| m.max(e.abs())),
            bar,
            unit: "",
        });
    }
    let mesh = Shape::parse("sphere:0.05@0.001")?.mesh();
    let curvature = mean_curvature(&mesh);
    let mean = curvature.iter().map(|h| (h * 0.05 - 1.0).abs()).sum::<f64>() / curvature.len() as f64;
    table.checks.push(Check {
        section: SECTION,
        quantity: "mean curvature at the vertices of `sphere:0.05@0.001`, average error".into(),
        reference: "1/R",
        error: mean,
        bar: 1e-2,
        unit: "",
    });
    Ok(())
}
