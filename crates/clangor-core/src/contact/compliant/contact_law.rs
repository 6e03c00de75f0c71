//! Force of one contact as a function of its approach, and its equation over one step.
//!
//! ```text
//! F = max(0, (Φ(x) − Φ(d))/(x − d) + γ(d̄)(x − d)/h)    Φ = (2/5) k d^{5/2}
//! d̄ = (d + x⁰)/2    x = x⁰ − aF
//! ```
//!
//! where d and x are the approach before and after the step, x⁰ that without force, and a the mobility over
//! the step [m/N]. With roots of d and x, the discrete gradient has no cancellation (shared note
//! "compliant contact", eq. 5). γ is frozen at the middle of the free motion, so that F rises with x and the
//! equation has one solution, between x⁰ − aF(x⁰) and x⁰.
//!
//! The average vector field, which this is for rigid bodies, is of second order: f becomes f + (h²/12) f′f′f.
//! With Φ + aF²/6 in place of Φ, a = ½h²/m, what remains is a change of variable, d by aF/6, which is none
//! where the bodies are apart. Velocities, and so the mean force of each step, are then exact to fourth
//! order, but for the first touch, damping, and modes above 1/h. A contact that stands at t₀ keeps Φ: the
//! change of variable would upset its balance.

/// Hertz's law of one contact with its losses, SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HertzLaw {
    /// Stiffness k of F = k d^{3/2} [N/m^1.5].
    pub stiffness: f64,
    /// α of the damping α √(k m_∞) d^{1/4}: restitution independent of speed; see
    /// [`restitution_damping`](super::restitution_damping).
    pub restitution_damping: f64,
    /// A of the viscoelastic damping (3/2) k A √d \[s\].
    pub viscosity: f64,
    /// κ of the waves into a half-space [s m/N]; see [`half_space_radiation`](super::half_space_radiation).
    pub radiation: f64,
    /// Mobility Y of an endless plate behind the contact [m/(N s)].
    pub plate_mobility: f64,
}

/// Force law of one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// Two curved surfaces that push but never pull.
    Hertz(HertzLaw),
    /// Linear and bilateral, F = k d + c ḋ: what hangs or stands on something soft. No friction.
    Spring {
        /// Stiffness k [N/m].
        stiffness: f64,
        /// Damping c [N s/m].
        damping: f64,
    },
}

/// Hertz's duration of the contact \[s\]: 2.9433 d/V with the greatest approach d = (5 m V²/(4k))^{2/5}.
///
/// `inverse_mass` [1/kg], `stiffness` [N/m^1.5] and `speed` [m/s] must be positive. \[PAN\] eq. (7).
pub fn hertz_duration(inverse_mass: f64, stiffness: f64, speed: f64) -> f64 {
    2.943_275 * (1.5625 / (inverse_mass * inverse_mass * stiffness * stiffness * speed)).powf(0.2)
}

/// The constants of a law over steps of one length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum StepLaw {
    /// k, and α√(k m_∞), (3/2)kA, κ((3/2)k)², each over h; Y; ak²/6.
    Hertz { stiffness: f64, damping: [f64; 3], plate: f64, cubic: f64 },
    /// k/2, c/h.
    Spring { half_stiffness: f64, damping: f64 },
}

/// Approach and force after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pressed {
    pub(super) approach: f64,
    pub(super) force: f64,
}

/// Discrete gradient of Hertz's energy between approaches with the roots a and b.
#[inline(always)]
fn gradient(stiffness: f64, a: f64, b: f64) -> f64 {
    let sum = a + b;
    if sum == 0.0 {
        return 0.0;
    }
    let (a2, b2, ab) = (a * a, b * b, a * b);
    0.4 * stiffness * (a2 * a2 + b2 * b2 + ab * (a2 + b2 + ab)) / sum
}

impl StepLaw {
    /// `mass`: m_∞ \[kg\]; `step`: h \[s\].
    pub(super) fn new(law: &ContactLaw, mass: f64, step: f64) -> Self {
        match *law {
            ContactLaw::Hertz(law) => {
                let k = law.stiffness;
                let damping = [
                    law.restitution_damping * (k * mass).sqrt(),
                    1.5 * k * law.viscosity,
                    law.radiation * (1.5 * k) * (1.5 * k),
                ];
                StepLaw::Hertz {
                    stiffness: k,
                    damping: damping.map(|gamma| gamma / step),
                    plate: law.plate_mobility,
                    cubic: 0.0,
                }
            }
            ContactLaw::Spring { stiffness, damping } => {
                StepLaw::Spring { half_stiffness: 0.5 * stiffness, damping: damping / step }
            }
        }
    }

    /// Adds the energy aF²/6 that makes the course of the force exact to fourth order in h.
    pub(super) fn sharpen(&mut self, mobility: f64) {
        if let StepLaw::Hertz { stiffness, cubic, .. } = self {
            *cubic = mobility * *stiffness * *stiffness / 6.0;
        }
    }

    /// Mobility Y of an endless plate in series [m/(N s)].
    pub(super) fn plate_mobility(&self) -> f64 {
        match *self {
            StepLaw::Hertz { plate, .. } => plate,
            StepLaw::Spring { .. } => 0.0,
        }
    }

    /// Energy \[J\] stored at an approach \[m\].
    pub(super) fn stored(&self, approach: f64) -> f64 {
        match *self {
            StepLaw::Hertz { stiffness, cubic, .. } if approach > 0.0 => {
                approach * approach * (0.4 * stiffness * approach.sqrt() + cubic * approach)
            }
            StepLaw::Hertz { .. } => 0.0,
            StepLaw::Spring { half_stiffness, .. } => half_stiffness * approach * approach,
        }
    }

    /// Whether the contact has no force over a step that ends at `free` without force.
    #[inline(always)]
    pub(super) fn stays_open(&self, before: f64, free: f64) -> bool {
        free <= 0.0 && before <= 0.0 && matches!(self, StepLaw::Hertz { .. })
    }

    /// γ/h at the middle of the free motion.
    #[inline(always)]
    fn frozen_damping(damping: &[f64; 3], before: f64, free: f64) -> f64 {
        let middle = (0.5 * (before + free)).max(0.0);
        let root = middle.sqrt();
        damping[0] * root.sqrt() + damping[1] * root + damping[2] * middle
    }

    /// Approach and force after a step from `before` that would end at `free` without this force.
    #[inline(always)]
    pub(super) fn press(&self, before: f64, free: f64, mobility: f64) -> Pressed {
        match self {
            StepLaw::Hertz { stiffness, damping, cubic, .. } => {
                press_hertz([*stiffness, *cubic], damping, before, free, mobility)
            }
            StepLaw::Spring { half_stiffness, damping } => {
                let push = half_stiffness * (before + free) + damping * (free - before);
                let force = push / (1.0 + mobility * (half_stiffness + damping));
                Pressed { approach: free - mobility * force, force }
            }
        }
    }

    /// Energy \[J\] that the contact turned into heat over a step; `free` as in [`StepLaw::press`].
    pub(super) fn loss(&self, before: f64, free: f64, pressed: Pressed) -> f64 {
        let change = pressed.approach - before;
        match self {
            StepLaw::Spring { damping, .. } => damping * change * change,
            // A force cut at zero gives nothing back of what was stored.
            StepLaw::Hertz { .. } if pressed.force == 0.0 => {
                (self.stored(before) - self.stored(pressed.approach)).max(0.0)
            }
            StepLaw::Hertz { damping, .. } => Self::frozen_damping(damping, before, free) * change * change,
        }
    }
}

/// Safeguarded secant for x + aF(x) = x⁰ in its bracket.
#[inline(always)]
fn press_hertz(
    [stiffness, cubic]: [f64; 2],
    damping: &[f64; 3],
    before: f64,
    free: f64,
    mobility: f64,
) -> Pressed {
    if free <= 0.0 && before <= 0.0 {
        return Pressed { approach: free, force: 0.0 };
    }
    let root = before.max(0.0).sqrt();
    let gamma = StepLaw::frozen_damping(damping, before, free);
    // Where one end is open, the quotient of differences has no cancellation either.
    let open = before < 0.0;
    let force = |x: f64| {
        let end = x.max(0.0).sqrt();
        let elastic = if open {
            x.max(0.0).powi(2) * (0.4 * stiffness * end + cubic * x) / (x - before)
        } else if x < 0.0 {
            before * before * (0.4 * stiffness * root + cubic * before) / (before - x)
        } else {
            gradient(stiffness, root, end) + cubic * (x * x + x * before + before * before)
        };
        (elastic + gamma * (x - before)).max(0.0)
    };
    let greatest = force(free);
    if greatest == 0.0 {
        return Pressed { approach: free, force: 0.0 };
    }
    let (mut low, mut high) = (free - mobility * greatest, free);
    let (mut x, mut f) = (high, greatest);
    let mut last: Option<(f64, f64)> = None;
    for _ in 0..80 {
        let excess = x + mobility * f - free;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        if excess.abs() <= 2e-16 * (free.abs() + mobility * f + before.abs()) || high - low <= 0.0 {
            break;
        }
        // Slope by secant; at first that of Hertz's law at this force.
        let slope = match last {
            Some((x0, excess0)) if x != x0 && excess != excess0 => (excess - excess0) / (x - x0),
            _ => 1.0 + mobility * f / (0.6 * (x - before.min(0.0)).abs().max(1e-300)),
        };
        let mut next = x - excess / slope;
        if !(next > low && next < high) {
            next = 0.5 * (low + high);
        }
        if next == x {
            break;
        }
        last = Some((x, excess));
        x = next;
        f = force(x);
    }
    // The motion follows from the force, so that both fit to rounding.
    Pressed { approach: free - mobility * f, force: f }
}
