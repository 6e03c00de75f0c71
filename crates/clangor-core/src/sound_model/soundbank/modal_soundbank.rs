//! Modal soundbank of ellipsoids of many proportions, and selection of the one for a body without modes of
//! its own.
//!
//! \[FRAC\] §5. The bank holds ellipsoids with semi-axes a ≤ b ≤ c, a² + b² + c² = 1 m², of one material in
//! one medium. With the principal moments I₁ ≥ I₂ ≥ I₃ of a body, eq. (12) is the ellipsoid with the same
//! proportions of inertia,
//!
//! ```text
//! â = (√(−I₁+I₂+I₃), √(I₁−I₂+I₃), √(I₁+I₂−I₃)) / √(I₁+I₂+I₃)
//! ```
//!
//! and the entry nearest to it is taken. It is scaled by γ so that its lowest mode has the frequency f₀ of
//! the body's:
//!
//! ```text
//! γ = (v'/v) f_p/f₀,   v = √(E/ρ);
//! f → (v'/v) f/γ,   U → √(m_p/m) U,   c_nm → √(ρ/ρ') γ^−3/2 c_nm,   R → γ R
//! ```
//!
//! with the masses m_p of the entry and m of the body. A body that is the entry scaled has m = (ρ'/ρ) γ³ m_p,
//! and then both factors are one. Differs: eq. (9) has γ^−3/2 for U of any body. But an entry that is thicker
//! than the body by a factor r has to be larger by r to have its lowest frequency, and heavier by r⁴; an
//! impact would move it r⁴ times less, while its sound, of an area r² and a motion r^−2 of the body's, would
//! be right.
//!
//! Eq. (9) says γ^−5/2 of the multipoles, because FRAC's are pressure per amplitude. Ours are c_nm of
//! [`ModalModel`](crate::sound_model::modal::model::ModalModel), pressure over ρ₀R per modal acceleration,
//! each wave made 1 on the bounding sphere: ω² R c is γ^(−2 + 1 − 3/2). At its mode's frequency kR does not
//! depend on the size, so that the scaling is exact.
//!
//! Another material of the same Poisson ratio has the same shapes, and frequencies in proportion to v. Its
//! transfers do depend on it, as kR ∝ v/c: those of the bank's material are taken, which
//! [`MOST_SPEED_DIFFERENCE`] bounds.
//!
//! Modes have parities in the three symmetry planes. A shape is a sum of spherical harmonics of the direction
//! ξ = x/â, and only those of its parity are kept: three of eight lists for the three components, one for the
//! pressure.
//!
//! **Contact.** A force at a place x of the body with the outer normal n acts on the proxy at ξ = â∘n/|â∘n|,
//! where the proxy has the normal Rn: eq. (24), x = a² n_x/√(a² n_x² + …) in closed form. [`ContactMapping`]
//! says what is done for flat bodies.
//!
//! Differs: what rounding leaves below 0 under a root of eq. (12) is 0. The published R = V_Iᵀ may be a
//! reflection; ours is a rotation. §5.4 prints v → γRv for the listener, which is R v/γ for a proxy that is
//! not scaled, and R v for one that is.

pub mod proxy;

use std::sync::Arc;

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::geometry::principal_axes::principal_axes;
use crate::math::spherical_harmonics::{HarmonicTable, count};
use crate::medium::Medium;

pub use proxy::{ContactMapping, ModalProxy, ModalProxyError, ProxyBody, serves};

/// Largest relative difference of v/c from that of the bank: the level of single modes is off by about as
/// much.
pub const MOST_SPEED_DIFFERENCE: f64 = 0.15;
/// Largest difference of Poisson's ratio from that of the bank: frequencies are off by at most a third as
/// much.
pub const MOST_POISSON_DIFFERENCE: f64 = 0.1;
/// Least semi-axis over the longest that counts in a lookup.
const THINNEST: f64 = 1e-3;
/// Difference of a² + b² + c² from 1 m².
const NORMALISED: f64 = 1e-9;

/// A mode of an ellipsoid of the bank.
#[derive(Clone, Debug, PartialEq)]
pub struct EllipsoidMode {
    /// ω/2π \[Hz\].
    pub frequency: f64,
    /// The coordinates in which the normal motion and the pressure are odd: bit 0 for x, 1 for y, 2 for z.
    /// Component i of the motion is odd in those and in its own, but even in what would be both.
    pub parity: u8,
    /// Of U_x, U_y, U_z [kg^−½] in the harmonics of their parities, see [`parity_harmonics`].
    pub shape: [Vec<f64>; 3],
    /// Highest order of the multipoles.
    pub order: usize,
    /// c_nm [kg^−½] of the harmonics of the mode's parity.
    pub transfer: Vec<Complex64>,
}

/// Modal model of an ellipsoid of the bank.
#[derive(Clone, Debug, PartialEq)]
pub struct RingingEllipsoid {
    /// a ≤ b ≤ c \[m\], along x, y, z.
    pub semi_axes: DVec3,
    /// There are no other modes below this \[Hz\].
    pub max_frequency: f64,
    /// The modes, by frequency.
    pub modes: Vec<EllipsoidMode>,
}

/// Material and medium of the ellipsoids of a bank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BankMaterial {
    /// E \[Pa\].
    pub youngs_modulus: f64,
    /// ρ [kg/m³].
    pub density: f64,
    /// ν \[-\].
    pub poisson_ratio: f64,
    /// The medium.
    pub medium: Medium,
}

impl BankMaterial {
    /// √(E/ρ) [m/s].
    pub fn speed(&self) -> f64 {
        (self.youngs_modulus / self.density).sqrt()
    }
}

/// Which harmonics shapes are made of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ShapeBasis {
    degree: usize,
    table: HarmonicTable,
    lists: [Vec<u32>; 8],
}

/// Ellipsoids of many proportions.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalSoundbank {
    material: BankMaterial,
    basis: Arc<ShapeBasis>,
    entries: Vec<Arc<RingingEllipsoid>>,
}

/// Error in the ellipsoids of a bank.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModalSoundbankError {
    /// No ellipsoids.
    #[error("the bank has no ellipsoids")]
    Empty,
    /// A material or a medium that no body has.
    #[error("the material of the bank has {what} {value}")]
    Material {
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Semi-axes that are out of order or not normalised.
    #[error(
        "ellipsoid {index} has the semi-axes {semi_axes}; expected 0 < a ≤ b ≤ c and a² + b² + c² = 1 m²"
    )]
    Axes {
        /// Which.
        index: usize,
        /// Its semi-axes \[m\].
        semi_axes: DVec3,
    },
    /// A mode that contradicts itself.
    #[error("mode {mode} of ellipsoid {index} has {what}")]
    Mode {
        /// Which ellipsoid.
        index: usize,
        /// Which mode.
        mode: usize,
        /// Reason.
        what: &'static str,
    },
}

/// The index of every harmonic up to a degree that has a parity: bit 0 is set where it is odd in x, bit 1 in
/// y, bit 2 in z.
pub fn parity_harmonics(parity: u8, degree: usize) -> Vec<u32> {
    let mut list = Vec::new();
    for n in 0..=degree {
        for m in -(n as isize)..=n as isize {
            // Under x → −x, φ → π − φ: cos mφ takes (−1)^m, sin mφ (−1)^{m+1}. Under z → −z: P_n^m takes
            // (−1)^{n+m}.
            let (sine, order) = (usize::from(m < 0), m.unsigned_abs());
            let own = ((order + sine) % 2) | (sine << 1) | (((n + order) % 2) << 2);
            if own == usize::from(parity) {
                list.push((n * n + n).wrapping_add_signed(m) as u32);
            }
        }
    }
    list
}

impl ShapeBasis {
    fn new(degree: usize) -> Self {
        let lists = std::array::from_fn(|parity| parity_harmonics(parity as u8, degree));
        ShapeBasis { degree, table: HarmonicTable::new(degree), lists }
    }

    /// Parity of component `axis` of the motion of a mode.
    fn list(&self, parity: u8, axis: usize) -> &[u32] {
        &self.lists[usize::from(parity) ^ (1 << axis)]
    }

    /// U [kg^−½] of a mode where the harmonics have these values.
    fn motion(&self, mode: &EllipsoidMode, harmonics: &[f64]) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| {
            let list = self.list(mode.parity, axis);
            list.iter().zip(&mode.shape[axis]).map(|(y, u)| harmonics[*y as usize] * u).sum()
        }))
    }
}

impl RingingEllipsoid {
    /// Largest γ at which all modes below a frequency \[Hz\] are there, for the material of the bank.
    pub fn largest_scale(&self, frequency: f64) -> f64 {
        self.max_frequency / frequency
    }
}

impl ModalSoundbank {
    /// A bank of ellipsoids of one material, whose shapes are harmonics up to `degree`.
    ///
    /// # Errors
    /// [`ModalSoundbankError`].
    pub fn try_new(
        material: BankMaterial,
        degree: usize,
        entries: Vec<RingingEllipsoid>,
    ) -> Result<Self, ModalSoundbankError> {
        let BankMaterial { youngs_modulus, density, poisson_ratio, medium } = material;
        for (what, value) in [
            ("Young's modulus", youngs_modulus),
            ("the density", density),
            ("a medium of density", medium.density),
            ("a medium of sound speed", medium.sound_speed),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ModalSoundbankError::Material { what, value });
            }
        }
        if !(poisson_ratio > -1.0 && poisson_ratio < 0.5) {
            return Err(ModalSoundbankError::Material { what: "Poisson's ratio", value: poisson_ratio });
        }
        if entries.is_empty() {
            return Err(ModalSoundbankError::Empty);
        }
        let basis = ShapeBasis::new(degree);
        for (index, entry) in entries.iter().enumerate() {
            let DVec3 { x: a, y: b, z: c } = entry.semi_axes;
            let normalised = (entry.semi_axes.length_squared() - 1.0).abs() <= NORMALISED;
            if !(a > 0.0 && b >= a && c >= b && normalised) {
                return Err(ModalSoundbankError::Axes { index, semi_axes: entry.semi_axes });
            }
            check_modes(index, entry, &basis)?;
        }
        let entries = entries.into_iter().map(Arc::new).collect();
        Ok(ModalSoundbank { material, basis: Arc::new(basis), entries })
    }

    /// Material and medium of the ellipsoids.
    pub fn material(&self) -> &BankMaterial {
        &self.material
    }

    /// Highest degree of the harmonics of shapes.
    pub fn degree(&self) -> usize {
        self.basis.degree
    }

    /// The ellipsoids.
    pub fn entries(&self) -> &[Arc<RingingEllipsoid>] {
        &self.entries
    }

    /// The ellipsoid nearest to the normalised semi-axes a ≤ b ≤ c.
    ///
    /// A search through all of some fifty: a tree, as \[FRAC\] has, would save nothing that could be noticed
    /// beside the lowest frequency.
    pub fn nearest(&self, semi_axes: DVec3) -> usize {
        let distance = |entry: &Arc<RingingEllipsoid>| entry.semi_axes.distance_squared(semi_axes);
        let nearest = (0..self.entries.len())
            .min_by(|i, j| distance(&self.entries[*i]).total_cmp(&distance(&self.entries[*j])));
        nearest.unwrap_or(0)
    }

    /// The proxy of a body.
    ///
    /// # Errors
    /// [`ModalProxyError`].
    pub fn proxy_for(&self, body: &ProxyBody) -> Result<ModalProxy, ModalProxyError> {
        ModalProxy::new(self, body)
    }
}

/// \[FRAC\] eq. (12): a ≤ b ≤ c with a² + b² + c² = 1, and the rotation from the frame of the inertia to that
/// of the ellipsoid, whose x is along the shortest axis.
///
/// Nothing for an inertia that no body has. What is thinner than a thousandth of its length counts as that
/// thick.
pub fn normalised_ellipsoid(inertia: DMat3) -> Option<(DVec3, DMat3)> {
    let (moments, axes) = principal_axes(inertia);
    let sum = moments.element_sum();
    if !(moments.x > 0.0 && sum.is_finite()) {
        return None;
    }
    // The least moment is about the longest axis.
    let square = (DVec3::splat(sum) - 2.0 * moments) / sum;
    let longest = square.x.sqrt();
    let [c, b, a] = square.to_array().map(|s| s.max(0.0).sqrt().max(THINNEST * longest));
    // An exchange of two axes with one turned round is a rotation.
    let rotation = DMat3::from_cols(-axes.z_axis, axes.y_axis, axes.x_axis).transpose();
    Some((DVec3::new(a, b, c).normalize(), rotation))
}

fn check_modes(
    index: usize,
    entry: &RingingEllipsoid,
    basis: &ShapeBasis,
) -> Result<(), ModalSoundbankError> {
    let mut last = 0.0;
    for (at, mode) in entry.modes.iter().enumerate() {
        let bad = |what| Err(ModalSoundbankError::Mode { index, mode: at, what });
        if !(mode.frequency > last * (1.0 - 1e-12) && mode.frequency.is_finite()) || mode.frequency <= 0.0 {
            return bad("a frequency below that before it");
        }
        last = mode.frequency;
        if mode.parity > 7 {
            return bad("no parity");
        }
        if (0..3).any(|axis| mode.shape[axis].len() != basis.list(mode.parity, axis).len()) {
            return bad("a shape of another number of harmonics");
        }
        let order = mode.order.min(u8::MAX.into());
        if mode.order != order || mode.transfer.len() != parity_harmonics(mode.parity, order).len() {
            return bad("a transfer of another number of multipoles");
        }
        let finite = mode.shape.iter().flatten().all(|u| u.is_finite());
        if !(finite && mode.transfer.iter().all(|c| c.is_finite())) {
            return bad("a number that is not finite");
        }
    }
    match entry.modes.is_empty() || !(entry.max_frequency >= last && entry.max_frequency.is_finite()) {
        true => Err(ModalSoundbankError::Mode {
            index,
            mode: entry.modes.len(),
            what: "no end of the band above it",
        }),
        false => Ok(()),
    }
}

/// The multipoles of all harmonics up to the order of a mode, times a factor.
fn all_multipoles(mode: &EllipsoidMode, factor: f64) -> Vec<Complex64> {
    let mut all = vec![Complex64::ZERO; count(mode.order)];
    for (at, c) in parity_harmonics(mode.parity, mode.order).iter().zip(&mode.transfer) {
        all[*at as usize] = factor * c;
    }
    all
}
