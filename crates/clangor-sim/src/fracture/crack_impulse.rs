//! Impulses with which the released stress of a crack drives the pieces apart; they determine the loudness of
//! a crack.
//!
//! On a triangle of the crack with area a and normal n out of piece a the body transmitted the traction P n.
//! The crack removes it. For a time τ the piece is subject to the unbalanced force, with the impulse
//!
//! ```text
//! j = −τ a P n    on piece a at the centroid,   −j on piece b
//! ΔE_K(τ) = τ Σ_d (v_d·S_d + ω_d·J_d) + τ²/2 Σ_d (|S_d|²/m_d + J_d·I_d⁻¹ J_d) = E_S − E_F
//! ```
//!
//! with S_d, J_d the sums of −a P n and of its moments over the triangles of piece d. P is the mean of the
//! stresses of the elements on both sides, so that impulses on both pieces are opposite, and momentum and
//! angular momentum are conserved. τ is the smallest positive root; the first sum vanishes if the pieces
//! still move as one body.
//!
//! Source: \[FRAC\] §3.3, eqs. (4), (5). Differs: the sign (eqs. (4) and (5) as printed pull the halves of a
//! stretched bar into each other), and one traction for each pair of triangles.
//!
//! Where the stress across the crack is compressive, the release pulls the pieces together, as in an elastic
//! body; contact then keeps them apart.

use clangor_core::glam::{DMat3, DVec3};

pub use super::error::NoImpulse;
use super::motion::Motion;
use super::split::CrackFace;

/// Impulses of a crack, and the motion of the pieces after it.
#[derive(Clone, Debug, PartialEq)]
pub struct CrackImpulses {
    /// Duration τ of the tractions \[s\].
    pub duration: f64,
    /// For each crack face the impulse on its piece a \[N s\], at the centroid; piece b gets the opposite.
    pub impulses: Vec<DVec3>,
    /// Motion of the pieces after the crack.
    pub motions: Vec<Motion>,
}

/// The impulses of a crack; `stress` \[Pa\] is the stress of each element of the unbroken body, `surplus`
/// \[J\] the strain energy after the crack, E_S − E_F. Pieces, faces and stresses use the same axes.
///
/// # Errors
/// [`NoImpulse`].
pub fn crack_impulses(
    faces: &[CrackFace],
    stress: &[DMat3],
    pieces: &[Motion],
    surplus: f64,
) -> Result<CrackImpulses, NoImpulse> {
    if surplus.is_nan() || surplus <= 0.0 {
        return Err(NoImpulse::NoSurplus(surplus));
    }
    for face in faces {
        let missing = |what, numbers: [u32; 2], count: usize| {
            let index = numbers.into_iter().map(|n| n as usize).find(|n| *n >= count)?;
            Some(NoImpulse::Missing { what, index, count })
        };
        let wrong = missing("piece", face.pieces, pieces.len());
        if let Some(reason) = wrong.or_else(|| missing("element", face.elements, stress.len())) {
            return Err(reason);
        }
    }
    // Unbalanced force of each face.
    let release = |face: &CrackFace| {
        let [p, q] = face.elements.map(|e| stress[e as usize]);
        -(0.5 * (p + q) * face.area_vector())
    };
    let forces: Vec<DVec3> = faces.iter().map(release).collect();
    // Sums over the triangles of each piece: force and moment about its centre.
    let mut sums = vec![(DVec3::ZERO, DVec3::ZERO); pieces.len()];
    for (face, force) in faces.iter().zip(&forces) {
        for (piece, force) in face.pieces.into_iter().zip([*force, -*force]) {
            let (total, moment) = &mut sums[piece as usize];
            *total += force;
            *moment += (face.centroid() - pieces[piece as usize].centre).cross(force);
        }
    }
    // Coefficients of the energy balance.
    let (mut linear, mut square) = (0.0, 0.0);
    for (piece, (force, moment)) in pieces.iter().zip(&sums) {
        linear += piece.velocity.dot(*force) + piece.angular_velocity.dot(*moment);
        square += 0.5 * (force.length_squared() / piece.mass + moment.dot(piece.inertia.inverse() * *moment));
    }
    if !(linear.is_finite() && square.is_finite() && square >= 0.0) {
        return Err(NoImpulse::NotFinite);
    }
    // square τ² + linear τ = surplus > 0 has one positive root; this form is free of cancellation.
    let root = (linear * linear + 4.0 * square * surplus).sqrt();
    let duration =
        if linear > 0.0 { 2.0 * surplus / (linear + root) } else { (root - linear) / (2.0 * square) };
    if square <= 0.0 || !duration.is_finite() {
        return Err(NoImpulse::NoTraction);
    }
    let move_on = |(piece, (force, moment)): (&Motion, &(DVec3, DVec3))| Motion {
        velocity: piece.velocity + duration / piece.mass * *force,
        angular_velocity: piece.angular_velocity + duration * (piece.inertia.inverse() * *moment),
        ..*piece
    };
    Ok(CrackImpulses {
        duration,
        impulses: forces.into_iter().map(|f| duration * f).collect(),
        motions: pieces.iter().zip(&sums).map(move_on).collect(),
    })
}
