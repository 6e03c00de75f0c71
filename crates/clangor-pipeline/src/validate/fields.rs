//! Acceleration noise of any shape: each solver against a closed form, the fit over frequency against
//! solutions that it has not seen, the bank that is shipped against its own ellipsoids solved afresh.
//!
//! Exact fields are written out here once more, at complex wavenumbers, as solvers may stay off the real
//! axis:
//!
//! ```text
//! sphere of radius 1, p e^{sr} = ρ a cos θ e^s (s/r + 1/r²)/(s² + 2s + 2),   s = ik
//! ellipsoid, k → 0: dipole moment V (1 + α/(2 − α)),
//!                   α = abc ∫₀^∞ dλ/((a² + λ) Δ),  Δ² = (a² + λ)(b² + λ)(c² + λ)
//! ```

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use clangor_bake::acceleration::{BakeOptions, bake};
use clangor_bake::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use clangor_bake::bem::symmetric_patches::SymmetricPatchSolver;
use clangor_bake::bem::triangles::{Equation, TriangleSolver};
use clangor_bake::fdtd::{Boundary, WaveOptions, WaveSolver};
use clangor_bake::fitting::comparison::directions;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::radiation::{RadiationSample, RadiationSolver};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::meridian::Meridian;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::math::radial::outgoing;
use clangor_core::math::spherical_harmonics::{index, solid_harmonics};
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_core::sound_model::acceleration::field::{AccelerationField, RIGID_DOFS};
use num_complex::Complex64;

use super::{Check, Extent, Outcome, Timing, Validation, cpu_time};
use crate::formats::soundbank::default_bank;

const SECTION: &str = "Acceleration noise of any shape";
/// ka of the spheres: to 20 kHz for a ball of 7.5 mm.
const BALL: [f64; 5] = [0.02, 0.5, 1.2, 2.0, 2.75];
/// Distances from the middle in bounding radii.
const DISTANCES: [f64; 4] = [1.2, 2.0, 8.0, 100.0];

pub(super) fn run(_extent: Extent, table: &mut Validation) -> Outcome {
    spheres(table)?;
    lamb(table)?;
    unseen_frequencies(table)?;
    bank(table)
}

fn add(table: &mut Validation, quantity: &str, reference: &'static str, error: f64, bar: f64) {
    table.checks.push(Check { section: SECTION, quantity: quantity.into(), reference, error, bar, unit: "" });
}

/// The accelerated sphere by four solvers.
fn spheres(table: &mut Validation) -> Outcome {
    let reference = "closed form of the dipole";
    let octant = SymmetricPatchSolver::ellipsoid(DVec3::ONE, 2.75, 1e-4)?.solve(&BALL, 8)?;
    add(
        table,
        "sphere by boundary elements on an octant, ka ≤ 2.75, 1.2 R to 100 R: six motions, worst",
        reference,
        sphere_error(&octant, &DISTANCES),
        1e-4,
    );
    let ball = Meridian::spheroid(1.0, 1.0)?;
    let meridian = AxisymmetricSolver::new(&ball, DVec3::new(0.3, -0.5, 0.8), AxisymmetricOptions::new(2.75))
        .solve(&BALL, 8)?;
    add(
        table,
        "the same by boundary elements on the meridian, about a slanted axis",
        reference,
        sphere_error(&meridian, &DISTANCES),
        1e-4,
    );
    let mut mesh = Shape::parse("sphere:1@0.23")?.mesh();
    let scale = (4.0 / 3.0 * PI / MassProperties::of(&mesh)?.volume).cbrt();
    mesh.vertices.iter_mut().for_each(|v| *v *= scale);
    let triangles = TriangleSolver::try_new(&mesh, 2.75, Equation::BurtonMiller)?.solve(&BALL, 4)?;
    add(
        table,
        &format!(
            "the same by Galerkin boundary elements on {} triangles, from 2 R (the corners stand out of \
             the sphere)",
            mesh.triangles.len()
        ),
        reference,
        sphere_error(&at_unit_radius(triangles, &mesh), &DISTANCES[1..]),
        1e-3,
    );
    let mesh = Shape::parse("sphere:1@0.02")?.mesh();
    let options = WaveOptions {
        max_wavenumber: 2.75,
        spacing: 0.125,
        order: 8,
        boundary: Boundary::CutCells,
        longest: 8.0,
    };
    let begin = cpu_time();
    let solver = WaveSolver::try_new(&mesh, options)?;
    let stepped = solver.run(&|_| ControlFlow::Continue(()))?.samples(&BALL, 8);
    table.timings.push(Timing {
        what: format!("six motions of a sphere stepped in time, {} cells", solver.cells()),
        cpu_seconds: cpu_time() - begin,
    });
    add(
        table,
        "the same by finite differences in time, 8 cells per radius, at 1.5 R",
        reference,
        sphere_error(&stepped, &[1.5]),
        6e-3,
    );
    Ok(())
}

/// Coefficients on the bounding sphere of a mesh that is a little larger than the sphere it stands for, on
/// that sphere.
fn at_unit_radius(mut samples: Vec<RadiationSample>, mesh: &TriMesh) -> Vec<RadiationSample> {
    let radius = mesh.bounding_radius(DVec3::ZERO);
    let mut radial = Vec::new();
    for sample in &mut samples {
        let order = sample.coefficients[0].len().isqrt() - 1;
        outgoing(Complex64::I * sample.wavenumber * radius, 1.0 / radius, order, &mut radial);
        for coefficients in &mut sample.coefficients {
            coefficients.iter_mut().enumerate().for_each(|(i, c)| *c *= radial[i.isqrt()]);
        }
    }
    samples
}

/// Worst error of six motions of a sphere of radius 1 over wavenumbers and distances: relative L2 over
/// directions against the translation.
fn sphere_error(samples: &[RadiationSample], distances: &[f64]) -> f64 {
    let mut worst = 0.0_f64;
    for sample in samples {
        let s = Complex64::I * sample.wavenumber;
        for r in distances {
            let size = s.exp() * (s / r + 1.0 / (r * r)) / (s * s + 2.0 * s + 2.0);
            let mut wrong = [0.0; RIGID_DOFS];
            for direction in directions(12) {
                let found = pressures(sample, direction * *r);
                for (degree, p) in found.into_iter().enumerate() {
                    let cosine = if degree < 3 { direction[degree] } else { 0.0 };
                    wrong[degree] += (p - size * cosine).norm_sqr();
                }
            }
            // The mean of cos² over the sphere is a third.
            let whole = size.norm_sqr() * 12.0 / 3.0;
            worst = wrong.into_iter().map(|w| (w / whole).sqrt()).fold(worst, f64::max);
        }
    }
    worst
}

/// p e^{s|x|} of the six motions at `x`, for coefficients on the sphere of radius 1.
fn pressures(sample: &RadiationSample, x: DVec3) -> [Complex64; RIGID_DOFS] {
    let order = sample.coefficients[0].len().isqrt() - 1;
    let r = x.length();
    let (mut radial, mut harmonics) = (Vec::new(), Vec::new());
    outgoing(Complex64::I * sample.wavenumber, r, order, &mut radial);
    solid_harmonics(x / r, order, &mut harmonics);
    let value = |(i, c): (usize, &Complex64)| c * harmonics[i] * radial[i.isqrt()];
    std::array::from_fn(|degree| sample.coefficients[degree].iter().enumerate().map(value).sum())
}

/// Added mass of ellipsoids at low frequency.
fn lamb(table: &mut Validation) -> Outcome {
    let reference = "Lamb, Hydrodynamics §114";
    for (name, across, along) in [("disc 20 : 20 : 1", 1.0, 0.05), ("needle 20 : 1 : 1", 0.05, 1.0)] {
        let solver = AxisymmetricSolver::new(
            &Meridian::spheroid(across, along)?,
            DVec3::Y,
            AxisymmetricOptions::new(1e-6),
        );
        add(
            table,
            &format!("{name}, k → 0, meridian: dipole moment of three translations, worst"),
            reference,
            dipole_error(&solver.solve(&[0.0], 2)?[0], DVec3::new(across, along, across)),
            2e-4,
        );
    }
    let axes = DVec3::new(1.0, 0.5, 0.25);
    let sample = SymmetricPatchSolver::ellipsoid(axes, 0.02, 1e-4)?.solve(&[0.0], 2)?;
    add(
        table,
        "ellipsoid 2 : 1 : 0.5, k → 0, octant: dipole moment of three translations, worst",
        reference,
        dipole_error(&sample[0], axes),
        2e-4,
    );
    Ok(())
}

/// Worst relative error of the dipole moments of an ellipsoid whose longest semi-axis is 1.
fn dipole_error(sample: &RadiationSample, axes: DVec3) -> f64 {
    let squares = axes * axes;
    let abc = axes.element_product();
    let error = |degree: usize| {
        // The trapezoidal rule in ln λ.
        let integral: f64 = (-900..900)
            .map(|k| (f64::from(k) * 0.05).exp())
            .map(|l| 0.05 * l / ((squares[degree] + l) * (squares + l).element_product().sqrt()))
            .sum();
        let alpha = abc * integral;
        let exact = abc / 3.0 * (1.0 + alpha / (2.0 - alpha)) / (0.75 / PI).sqrt();
        (sample.coefficients[degree][index(1, [1, -1, 0][degree])] - exact).norm() / exact
    };
    (0..3).map(error).fold(0.0, f64::max)
}

/// A coin, baked as the program does, at frequencies that were not solved.
fn unseen_frequencies(table: &mut Validation) -> Outcome {
    let meridian = Shape::parse("coin")?.meridian().ok_or("a coin has no meridian")?.about_centre_of_mass();
    let radius = meridian.bounding_radius();
    let highest = TAU * 20_000.0 / Medium::AIR.sound_speed;
    let options = BakeOptions::new(highest, 3e-3);
    let begin = cpu_time();
    let (model, evidence) =
        bake(&BakeGeometry::axisymmetric(meridian.clone()), &options, &mut |_| ControlFlow::Continue(()))?;
    table.timings.push(Timing {
        what: format!("bake of a coin to 20 kHz at 3e-3, {} solves", evidence.solves),
        cpu_seconds: cpu_time() - begin,
    });
    let wavenumbers = [0.013, 0.19, 0.371, 0.52, 0.683, 0.87, 0.99].map(|part| part * highest);
    let finer = AxisymmetricOptions {
        nodes_per_wavelength: 12.0,
        edge_levels: 6,
        ..AxisymmetricOptions::new(highest)
    };
    let solver = AxisymmetricSolver::new(&meridian, DVec3::Y, finer);
    let error = level_error(&model.field, &solver.solve(&wavenumbers, 16)?, radius, 2.0);
    add(
        table,
        "coin baked to 20 kHz at 3e-3, at seven frequencies between those solved, 2 R: level error, worst \
         motion",
        "the meridian solved at these frequencies, finer",
        error,
        3e-3,
    );
    Ok(())
}

/// The bank that comes with the program.
fn bank(table: &mut Validation) -> Outcome {
    let bank = default_bank().ok_or("the bank of the program cannot be used")?;
    for (b, c) in [(0.525, 0.24), (1.0, 0.05)] {
        let near = |e: &&clangor_core::sound_model::soundbank::ellipsoid_bank::BankEntry| {
            (e.b - b).abs() + (e.c - c).abs() < 1e-6
        };
        let entry = bank.bank().entries().iter().find(near).ok_or("the bank lacks an ellipsoid")?;
        let solver = SymmetricPatchSolver::ellipsoid(DVec3::new(1.0, b, c), 20.0, 1e-4)?;
        let samples = solver.solve(&[0.7, 5.3, 11.9, 18.3], 24)?;
        add(
            table,
            &format!(
                "ellipsoid 1 : {b} : {c} of the bank that is shipped, kA ≤ 20, 2 A: level error, worst motion"
            ),
            "the ellipsoid solved afresh, finer",
            level_error(&entry.field, &samples, 1.0, 2.0),
            1e-3,
        );
    }
    Ok(())
}

/// Level error of a field against samples of the same body, at a distance in bounding radii: root mean square
/// over the wavenumbers of the error over the loudest motion, of the motion where it is worst.
fn level_error(field: &AccelerationField, samples: &[RadiationSample], radius: f64, distance: f64) -> f64 {
    let mut squares = [0.0; RIGID_DOFS];
    for sample in samples {
        let s = Complex64::I * sample.wavenumber * radius;
        let scaled = RadiationSample {
            wavenumber: sample.wavenumber * radius,
            coefficients: std::array::from_fn(|degree| {
                let unit = if degree < 3 { radius } else { radius * radius };
                sample.coefficients[degree].iter().map(|c| c / unit).collect()
            }),
            surface_pressure: Vec::new(),
        };
        let (mut wrong, mut size) = ([0.0; RIGID_DOFS], [0.0; RIGID_DOFS]);
        for direction in directions(20) {
            let x = direction * distance;
            for (degree, exact) in pressures(&scaled, x).into_iter().enumerate() {
                let z = std::array::from_fn(|i| if i == degree { 1.0 } else { 0.0 });
                let found = field.interpolate(s, &field.at_nodes(&z, x));
                wrong[degree] += (found - exact).norm_sqr();
                size[degree] += exact.norm_sqr();
            }
        }
        let loudest = size.into_iter().fold(0.0, f64::max);
        squares.iter_mut().zip(wrong).for_each(|(sum, w)| *sum += w / loudest / samples.len() as f64);
    }
    squares.into_iter().fold(0.0, f64::max).sqrt()
}
