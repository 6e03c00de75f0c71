//! Meridian of a body of revolution: a curve in the half-plane (r, y) beside its axis.
//!
//! Unlike a mesh it is exact: straight lines and arcs of circles and ellipses. It runs counter-clockwise
//! around the material, so that the outward normal is to the right of its direction. It leads from the lower
//! to the upper part of the axis, or around a closed loop off the axis.
//!
//! ```text
//! V = ∮ π r² dy,    y_c = ∮ π r² y dy / V
//! ```

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DVec2, DVec3};

use super::mass_properties::MassProperties;

/// Error in the meridian of a body of revolution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeridianError {
    /// No pieces, or a coordinate that is not finite.
    #[error("piece {piece} of the meridian is not finite")]
    NotFinite {
        /// Index of the piece.
        piece: usize,
    },
    /// A point on the wrong side of the axis.
    #[error("piece {piece} of the meridian reaches r = {r:.3e}, across the axis")]
    CrossesAxis {
        /// Index of the piece.
        piece: usize,
        /// Its smallest radius \[m\].
        r: f64,
    },
    /// A gap between two pieces, or an open end off the axis.
    #[error("the meridian is open after piece {piece}, at r = {:.3e}, y = {:.3e}", point.x, point.y)]
    Open {
        /// The piece before the gap.
        piece: usize,
        /// Its end \[m\].
        point: DVec2,
    },
    /// The curve has the wrong sense, or encloses no volume.
    #[error(
        "the meridian encloses a volume of {volume:.3e} m³; it must run counter-clockwise around the material"
    )]
    NoVolume {
        /// The volume \[m³\].
        volume: f64,
    },
}

/// A smooth piece of a meridian, with a parameter t from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight line.
    Line {
        /// Start \[m\].
        from: DVec2,
        /// End \[m\].
        to: DVec2,
    },
    /// An arc of a circle or ellipse: centre + (a cos θ, b sin θ).
    Arc {
        /// Centre \[m\].
        centre: DVec2,
        /// Semi-axes a along r and b along y \[m\].
        semi_axes: DVec2,
        /// θ at the start \[rad\].
        from: f64,
        /// θ at the end \[rad\]; smaller than `from` for a clockwise arc.
        to: f64,
    },
}

impl Piece {
    /// Point at t \[m\].
    pub fn point(&self, t: f64) -> DVec2 {
        match *self {
            Piece::Line { from, to } => from + (to - from) * t,
            Piece::Arc { centre, semi_axes, from, to } => {
                let (sin, cos) = (from + (to - from) * t).sin_cos();
                centre + semi_axes * DVec2::new(cos, sin)
            }
        }
    }

    /// d point / dt \[m\].
    pub fn velocity(&self, t: f64) -> DVec2 {
        match *self {
            Piece::Line { from, to } => to - from,
            Piece::Arc { semi_axes, from, to, .. } => {
                let (sin, cos) = (from + (to - from) * t).sin_cos();
                semi_axes * DVec2::new(-sin, cos) * (to - from)
            }
        }
    }

    /// point(t + step) − point(t), without cancellation however small the step, and its product with the
    /// outward normal there times the speed there \[m²\].
    pub fn chord(&self, t: f64, step: f64) -> (DVec2, f64) {
        match *self {
            Piece::Line { from, to } => ((to - from) * step, 0.0),
            Piece::Arc { semi_axes, from, to, .. } => {
                let half = 0.5 * (to - from) * step;
                let (sin, cos) = (from + (to - from) * t + half).sin_cos();
                let sine = half.sin();
                let chord = semi_axes * DVec2::new(-sin, cos) * (2.0 * sine);
                (chord, (to - from) * semi_axes.x * semi_axes.y * 2.0 * sine * sine)
            }
        }
    }

    /// Radius of curvature at t \[m\]; infinite on a line.
    pub fn curvature_radius(&self, t: f64) -> f64 {
        match *self {
            Piece::Line { .. } => f64::INFINITY,
            Piece::Arc { semi_axes, from, to, .. } => {
                let (sin, cos) = (from + (to - from) * t).sin_cos();
                (semi_axes * DVec2::new(sin, cos)).length().powi(3) / (semi_axes.x * semi_axes.y)
            }
        }
    }

    /// Length from t = `start` to `end` \[m\].
    pub fn length(&self, start: f64, end: f64) -> f64 {
        match *self {
            Piece::Line { from, to } => from.distance(to) * (end - start).abs(),
            Piece::Arc { .. } => {
                integrate(|t| self.velocity(start + (end - start) * t).length()) * (end - start).abs()
            }
        }
    }

    fn moved(self, by: DVec2) -> Self {
        match self {
            Piece::Line { from, to } => Piece::Line { from: from + by, to: to + by },
            Piece::Arc { centre, semi_axes, from, to } => {
                Piece::Arc { centre: centre + by, semi_axes, from, to }
            }
        }
    }

    fn is_finite(&self) -> bool {
        match *self {
            Piece::Line { from, to } => from.is_finite() && to.is_finite() && from != to,
            Piece::Arc { centre, semi_axes, from, to } => {
                centre.is_finite()
                    && semi_axes.is_finite()
                    && semi_axes.min_element() > 0.0
                    && (to - from).is_finite()
                    && to != from
            }
        }
    }

    /// Smallest r \[m\].
    fn narrowest(&self) -> f64 {
        let ends = self.point(0.0).x.min(self.point(1.0).x);
        match *self {
            Piece::Line { .. } => ends,
            Piece::Arc { centre, semi_axes, from, to } => {
                // r is least where θ is an odd multiple of π.
                let (low, high) = (from.min(to), from.max(to));
                let turn = ((low / PI - 1.0) / 2.0).ceil() * 2.0 + 1.0;
                if turn * PI <= high { ends.min(centre.x - semi_axes.x) } else { ends }
            }
        }
    }
}

/// The section of a body of revolution about y; see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct Meridian {
    pieces: Vec<Piece>,
}

/// Three-point Gauss on 64 equal parts of [0, 1].
fn integrate(f: impl Fn(f64) -> f64) -> f64 {
    const PARTS: usize = 64;
    let reach = 0.5 * 0.6_f64.sqrt();
    (0..PARTS)
        .map(|k| {
            let at = |x: f64| f((k as f64 + x) / PARTS as f64);
            (5.0 * (at(0.5 - reach) + at(0.5 + reach)) + 8.0 * at(0.5)) / 18.0
        })
        .sum::<f64>()
        / PARTS as f64
}

impl Meridian {
    /// A meridian from its pieces in order.
    ///
    /// # Errors
    /// [`MeridianError`]; whether the curve crosses itself is not checked.
    pub fn try_new(pieces: Vec<Piece>) -> Result<Self, MeridianError> {
        if let Some(piece) = pieces.iter().position(|p| !p.is_finite()) {
            return Err(MeridianError::NotFinite { piece });
        }
        let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else {
            return Err(MeridianError::NotFinite { piece: 0 });
        };
        let size = pieces.iter().map(|p| p.point(0.0).abs().max_element()).fold(0.0, f64::max);
        let slack = 1e-9 * size;
        for (piece, p) in pieces.iter().enumerate() {
            let r = p.narrowest();
            if r < -slack {
                return Err(MeridianError::CrossesAxis { piece, r });
            }
            let end = p.point(1.0);
            if pieces.get(piece + 1).is_some_and(|next| next.point(0.0).distance(end) > slack) {
                return Err(MeridianError::Open { piece, point: end });
            }
        }
        let (start, end) = (first.point(0.0), last.point(1.0));
        if start.x.max(end.x) > slack && start.distance(end) > slack {
            return Err(MeridianError::Open { piece: pieces.len() - 1, point: end });
        }
        let meridian = Meridian { pieces };
        let volume = meridian.volume();
        if volume.is_nan() || volume <= 1e-12 * size.powi(3) {
            return Err(MeridianError::NoVolume { volume });
        }
        Ok(meridian)
    }

    /// A spheroid: semi-axes across and along the axis \[m\].
    ///
    /// # Errors
    /// [`MeridianError`] if one is not positive and finite.
    pub fn spheroid(across: f64, along: f64) -> Result<Self, MeridianError> {
        Self::try_new(vec![Piece::Arc {
            centre: DVec2::ZERO,
            semi_axes: DVec2::new(across, along),
            from: -FRAC_PI_2,
            to: FRAC_PI_2,
        }])
    }

    /// The pieces, from the axis below to the axis above or around the loop.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Whether it is a loop, its end joined to its start.
    pub fn is_loop(&self) -> bool {
        let (start, end) = (self.pieces[0].point(0.0), self.pieces[self.pieces.len() - 1].point(1.0));
        start.distance(end) <= 1e-9 * self.bounding_radius()
    }

    /// Volume of the body \[m³\].
    pub fn volume(&self) -> f64 {
        self.moment(|_| PI)
    }

    /// Height of the centre of mass of the homogeneous body \[m\].
    pub fn centre_of_mass(&self) -> f64 {
        self.moment(|y| PI * y) / self.volume()
    }

    /// Volume, centre of mass and inertia of the homogeneous body of unit density, revolved about y.
    pub fn mass_properties(&self) -> MassProperties {
        let volume = self.volume();
        let centre = self.centre_of_mass();
        // ∫ y² dV about the centre, and ∫ r² dV = ∮ (π/2) r⁴ dy.
        let along = self.moment(|y| PI * (y - centre) * (y - centre));
        let term = |piece: &Piece| integrate(|t| 0.5 * PI * piece.point(t).x.powi(4) * piece.velocity(t).y);
        let about: f64 = self.pieces.iter().map(term).sum();
        let across = 0.5 * about + along;
        MassProperties {
            volume,
            centre_of_mass: DVec3::Y * centre,
            inertia: DMat3::from_diagonal(DVec3::new(across, about, across)),
        }
    }

    /// Area of the surface \[m²\]: ∮ 2π r ds.
    pub fn area(&self) -> f64 {
        let term = |piece: &Piece| integrate(|t| 2.0 * PI * piece.point(t).x * piece.velocity(t).length());
        self.pieces.iter().map(term).sum()
    }

    /// ∮ f(y) r² dy.
    fn moment(&self, f: impl Fn(f64) -> f64) -> f64 {
        let term = |piece: &Piece| {
            integrate(|t| {
                let p = piece.point(t);
                f(p.y) * p.x * p.x * piece.velocity(t).y
            })
        };
        self.pieces.iter().map(term).sum()
    }

    /// The same curve higher by `by` \[m\].
    pub fn raised(&self, by: f64) -> Self {
        let by = DVec2::new(0.0, by);
        Meridian { pieces: self.pieces.iter().map(|p| p.moved(by)).collect() }
    }

    /// The same curve with the centre of mass at y = 0.
    pub fn about_centre_of_mass(&self) -> Self {
        self.raised(-self.centre_of_mass())
    }

    /// Largest distance of a point from the origin \[m\].
    pub fn bounding_radius(&self) -> f64 {
        self.pieces.iter().map(farthest).fold(0.0, f64::max)
    }
}

/// Largest distance of a piece from the origin.
fn farthest(piece: &Piece) -> f64 {
    let at = |t: f64| piece.point(t).length();
    let ends = at(0.0).max(at(1.0));
    if let Piece::Line { .. } = piece {
        return ends;
    }
    const PARTS: usize = 64;
    let grid = (0..=PARTS).map(|k| k as f64 / PARTS as f64);
    let middle = grid.max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(0.0);
    let (mut low, mut high) =
        ((middle - 1.0 / PARTS as f64).max(0.0), (middle + 1.0 / PARTS as f64).min(1.0));
    for _ in 0..60 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(a) < at(b) { low = a } else { high = b }
    }
    ends.max(at(0.5 * (low + high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_and_centres_are_the_known_ones() {
        let ball = Meridian::spheroid(2.0, 3.0).expect("a spheroid");
        // Residuals seen: 1e-14 and less.
        assert!((ball.volume() / (16.0 * PI) - 1.0).abs() < 1e-11, "{}", ball.volume());
        assert!((ball.bounding_radius() - 3.0).abs() < 1e-14);
        assert!(!ball.is_loop());
        let half = Meridian::try_new(vec![
            Piece::Line { from: DVec2::ZERO, to: DVec2::X },
            Piece::Arc { centre: DVec2::ZERO, semi_axes: DVec2::ONE, from: 0.0, to: FRAC_PI_2 },
        ])
        .expect("half a ball");
        assert!((half.centre_of_mass() - 0.375).abs() < 1e-11);
        assert!(half.about_centre_of_mass().centre_of_mass().abs() < 1e-11);
        let torus = Meridian::try_new(vec![Piece::Arc {
            centre: 3.0 * DVec2::X,
            semi_axes: DVec2::ONE,
            from: 0.0,
            to: 2.0 * PI,
        }])
        .expect("a torus");
        assert!((torus.volume() / (6.0 * PI * PI) - 1.0).abs() < 1e-11);
        assert!(torus.is_loop() && (torus.bounding_radius() - 4.0).abs() < 1e-14);
    }

    #[test]
    fn areas_and_moments_are_the_known_ones() {
        let ball = Meridian::spheroid(2.0, 2.0).expect("a sphere");
        let (mass, exact) = (ball.mass_properties(), MassProperties::of_sphere(2.0));
        // Residuals seen: 1e-14 and less.
        assert!((ball.area() / (16.0 * PI) - 1.0).abs() < 1e-11, "{}", ball.area());
        assert!((mass.inertia - exact.inertia).abs().to_cols_array().iter().all(|x| x / 53.6 < 1e-11));
        let line = |a: DVec2, b: DVec2| Piece::Line { from: a, to: b };
        let [a, b, c, d] =
            [DVec2::new(1.0, 2.0), DVec2::new(3.0, 2.0), DVec2::new(3.0, 3.0), DVec2::new(1.0, 3.0)];
        let tube = Meridian::try_new(vec![line(a, b), line(b, c), line(c, d), line(d, a)]).expect("a tube");
        let mass = tube.mass_properties();
        let (volume, height) = (8.0 * PI, mass.centre_of_mass.y);
        // V (R² + r²)/2 about the axis, V (3 (R² + r²) + h²)/12 across it.
        assert!((mass.volume - volume).abs() < 1e-9 && (height - 2.5).abs() < 1e-9);
        assert!((mass.inertia.y_axis.y - 5.0 * volume).abs() < 1e-9);
        assert!((mass.inertia.x_axis.x - volume * 31.0 / 12.0).abs() < 1e-9);
        assert!((tube.area() - 24.0 * PI).abs() < 1e-9);
    }

    #[test]
    fn chords_are_differences() {
        let arc =
            Piece::Arc { centre: DVec2::new(0.3, 1.0), semi_axes: DVec2::new(2.0, 0.5), from: 2.0, to: -0.3 };
        for (t, step) in [(0.2, 0.3), (0.9, -0.4), (0.5, 1e-3)] {
            let (chord, normal) = arc.chord(t, step);
            let v = arc.velocity(t + step);
            let difference = arc.point(t + step) - arc.point(t);
            // Residual seen: 2e-16.
            assert!((chord - difference).length() < 1e-14);
            assert!((normal - difference.dot(DVec2::new(v.y, -v.x))).abs() < 1e-14, "{normal}");
        }
    }

    #[test]
    fn what_is_no_section_is_refused() {
        let line = |a: DVec2, b: DVec2| Piece::Line { from: a, to: b };
        let refused = |pieces: Vec<Piece>| Meridian::try_new(pieces).expect_err("no section");
        assert!(matches!(refused(vec![]), MeridianError::NotFinite { .. }));
        assert!(matches!(
            refused(vec![line(DVec2::ZERO, DVec2::NAN)]),
            MeridianError::NotFinite { piece: 0 }
        ));
        let open = vec![line(DVec2::ZERO, DVec2::X), line(DVec2::X, DVec2::ONE)];
        assert!(matches!(refused(open), MeridianError::Open { piece: 1, .. }));
        let turned =
            vec![line(DVec2::Y, DVec2::ONE), line(DVec2::ONE, DVec2::X), line(DVec2::X, DVec2::ZERO)];
        assert!(matches!(refused(turned), MeridianError::NoVolume { .. }));
        let across = Piece::Arc { centre: 0.5 * DVec2::X, semi_axes: DVec2::ONE, from: 0.0, to: 2.0 * PI };
        assert!(matches!(refused(vec![across]), MeridianError::CrossesAxis { .. }));
    }
}
