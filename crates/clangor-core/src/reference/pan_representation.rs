//! The published representation of acceleration noise: \[PAN\] §4.2 and \[PROXY\] §4.
//!
//! The pressure of a short acceleration pulse ψ(t; h) in each of the six rigid degrees of freedom is stored
//! along a number of [`directions`], as a series in the distance whose coefficients are signals in time:
//!
//! ```text
//! p_i(r, θ, φ, t) = Σ_{k=1}^{N} q_{i,k}(θ, φ, t − r/c)/r^k          [PAN] eq. (20), [PROXY] eq. (8)
//! p(x, t) = Σ_j Σ_i z_i(jh) p_i(x, t − jh)                          [PAN] eqs. (18), (19), [PROXY] eq. (15)
//! ```
//!
//! with z = (a, α) the acceleration in the frame of the body. In between directions the signals are
//! interpolated linearly.
//!
//! Lengths are in units of the body's bounding radius R, times in R/c, pressures in ρR for z = (a, Rα): a
//! body β times as large has the same signals with the pulse βh, which is \[PROXY\] eq. (10).
//!
//! A field of wavelet coefficients sampled faster than the output needs is reconstructed at a lower rate,
//! octave by octave (\[PROXY\] algorithm 1). Differs: the reconstructed signal is evaluated at its true
//! times, μ samples later at each octave ([`wavelet::HALVING_SHIFT`]); the papers do not mention the shift.
//!
//! Differs: between samples the summed signal is the band-limited one, below 0.45 of the output rate; \[PAN\]
//! eq. (22) interpolates with ψ, which at the output rate would alias.
//!
//! Fields with pulses h, 2h, 4h and 8h can stand side by side (\[PAN\] fig. 9); a contact takes the longest
//! pulse that is at most a fifth of it, which is how \[PAN\] §4.3 chooses h for the shortest contact.
//!
//! It serves for comparison:
//! [`AccelerationField`](crate::sound_model::acceleration::field::AccelerationField) is smaller, faster and
//! valid at every distance.

pub mod directions;
pub mod pulse;
pub mod resampling;
pub mod signals;
pub mod wavelet;

use glam::DVec3;

use self::directions::Directions;
use self::resampling::Series;
use self::signals::Signals;
use crate::medium::Medium;
use crate::sound_model::acceleration::field::RIGID_DOFS;

/// Duration of a contact over the longest pulse that may represent it (\[PAN\] §4.3).
pub const PULSES_PER_CONTACT: f64 = 5.0;
/// Highest frequency of the output over its rate.
pub const OUTPUT_BAND: f64 = 0.45;
/// Largest number of samples of a sound, and of pulses of a contact.
const MOST: f64 = 16_777_216.0;
/// Relative amplitude of the omitted ends of a signal, over its peak.
const SILENCE: f64 = 1e-6;

/// Error in the published representation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PanError {
    /// No field.
    #[error("a published model needs at least one field")]
    Empty,
    /// An inconsistent field.
    #[error("field {field} of the published model is inconsistent: {what}")]
    Inconsistent {
        /// Index of the field.
        field: usize,
        /// The violated condition.
        what: &'static str,
    },
    /// A number that must be finite, or positive.
    #[error("{what} is {value}")]
    BadNumber {
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A sound too long for the memory.
    #[error("a contact of {duration} s needs {samples:.3e} samples, more than {most}", most = MOST)]
    TooLong {
        /// Duration \[s\].
        duration: f64,
        /// Number of samples, or of pulses if that is larger.
        samples: f64,
    },
    /// The listener is inside the bounding sphere, where the series in 1/r is invalid.
    #[error("the listener is {distance} m from the centre of mass, inside the bounding sphere of {radius} m")]
    ListenerInside {
        /// Distance \[m\].
        distance: f64,
        /// Bounding radius \[m\].
        radius: f64,
    },
}

/// Response to the pulse of one width.
#[derive(Clone, Debug, PartialEq)]
pub struct PanField {
    /// h [R/c].
    pub pulse: f64,
    /// Time between samples [R/c].
    pub step: f64,
    /// t − r/c of the first sample [R/c], t = 0 in the middle of the pulse.
    pub start: f64,
    /// Samples of each signal; a power of two for wavelets.
    pub length: usize,
    /// N: powers of 1/r.
    pub terms: usize,
    /// Directions of the signals.
    pub directions: Directions,
    /// The signals.
    pub signals: Signals,
}

impl PanField {
    /// Bytes of the signals.
    pub fn bytes(&self) -> usize {
        self.signals.bytes()
    }

    /// Σ_i z_i p_i at `x`, in units of ρR over t − |x| [R/c], for z = (a, Rα); wavelets at a rate that is at
    /// most twice `rate` [c/R] as far as halving it can reach that.
    pub fn response(&self, z: &[f64; RIGID_DOFS], x: DVec3, rate: f64) -> Series {
        let neighbours = self.directions.neighbours(x);
        let distance = x.length();
        let (mut step, mut start, mut length) = (self.step, self.start, self.length);
        let mut scale = 1.0;
        if let Signals::Wavelets(_) = self.signals {
            while 1.0 / step > 2.0 * rate && length > 1 {
                start += wavelet::HALVING_SHIFT * step;
                step *= 2.0;
                length /= 2;
                scale *= std::f64::consts::FRAC_1_SQRT_2;
            }
        }
        let mut sum = vec![0.0; length];
        let mut radial = vec![0.0; self.terms];
        for (direction, weight) in neighbours.weights {
            for (degree, (z, sign)) in z.iter().zip(neighbours.signs).enumerate() {
                let factor = scale * weight * sign * z;
                if factor == 0.0 {
                    continue;
                }
                radial.iter_mut().zip(1..).for_each(|(r, k)| *r = factor * distance.powi(-k));
                let pair = direction * RIGID_DOFS + degree;
                match &self.signals {
                    Signals::Wavelets(sparse) => sparse.add(pair, &radial, &mut sum),
                    Signals::Samples(samples) => {
                        let all = &samples[pair * self.terms * length..][..self.terms * length];
                        for (q, r) in all.chunks_exact(length).zip(&radial) {
                            sum.iter_mut().zip(q).for_each(|(s, &q)| *s += r * f64::from(q));
                        }
                    }
                }
            }
        }
        let samples = match &self.signals {
            Signals::Wavelets(_) => {
                wavelet::inverse(&mut sum);
                sum
            }
            Signals::Samples(_) => filtered(&sum),
        };
        Series { start, step, samples }
    }

    fn inconsistency(&self) -> Option<&'static str> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !(positive(self.pulse) && positive(self.step) && self.start.is_finite()) {
            return Some("a time is not positive");
        }
        if self.terms == 0 || self.length == 0 || !self.directions.is_valid() {
            return Some("a count is zero");
        }
        if matches!(self.signals, Signals::Wavelets(_)) && !self.length.is_power_of_two() {
            return Some("the wavelets' length is not a power of two");
        }
        (!self.signals.fits(self.directions.count() * RIGID_DOFS, self.terms, self.length))
            .then_some("the signals are not as many as the directions need, or not finite")
    }
}

/// Σ_j q_j ψ(t − jΔt; Δt) at t = iΔt (\[PAN\] eq. (22)).
fn filtered(q: &[f64]) -> Vec<f64> {
    let (centre, side) = (pulse::pulse(0.0, 1.0), pulse::pulse(1.0, 1.0));
    (0..q.len())
        .map(|i| {
            let before = if i > 0 { q[i - 1] } else { 0.0 };
            let after = q.get(i + 1).copied().unwrap_or(0.0);
            centre * q[i] + side * (before + after)
        })
        .collect()
}

/// A contact that accelerates the body along a half-sine, and its listener.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeardContact {
    /// Peak of the acceleration, a [m/s²] then α [rad/s²], in the frame of the body.
    pub peak: [f64; RIGID_DOFS],
    /// Onset \[s\].
    pub onset: f64,
    /// Duration τ \[s\].
    pub duration: f64,
    /// The listener from the centre of mass, in the frame of the body \[m\].
    pub listener: DVec3,
}

/// Time profile of an acceleration: `shape` of the time after the onset, zero before `from` and after `to`
/// \[s\].
#[derive(Clone, Copy)]
pub struct ForceWindow<'a> {
    /// Begin \[s\].
    pub from: f64,
    /// End \[s\].
    pub to: f64,
    /// Factor of the peak.
    pub shape: &'a dyn Fn(f64) -> f64,
}

/// Samples of a sound.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedContact {
    /// Index of the first sample: sample n is received at n over the rate \[s\].
    pub first: i64,
    /// Pressure \[Pa\].
    pub samples: Vec<f64>,
}

/// The published representation of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct PanModel {
    radius: f64,
    fields: Vec<PanField>,
}

impl PanModel {
    /// A body of bounding radius `radius` \[m\] with fields of one or more pulses.
    ///
    /// # Errors
    /// Inconsistent fields.
    pub fn new(radius: f64, mut fields: Vec<PanField>) -> Result<Self, PanError> {
        check("the bounding radius", radius, radius > 0.0)?;
        if fields.is_empty() {
            return Err(PanError::Empty);
        }
        for (field, content) in fields.iter().enumerate() {
            if let Some(what) = content.inconsistency() {
                return Err(PanError::Inconsistent { field, what });
            }
        }
        fields.sort_by(|a, b| a.pulse.total_cmp(&b.pulse));
        Ok(PanModel { radius, fields })
    }

    /// Bounding radius R \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Fields, the shortest pulse first.
    pub fn fields(&self) -> &[PanField] {
        &self.fields
    }

    /// Bytes of all signals.
    pub fn bytes(&self) -> usize {
        self.fields.iter().map(PanField::bytes).sum()
    }

    /// The field for a contact of this duration \[s\].
    pub fn field(&self, duration: f64, sound_speed: f64) -> &PanField {
        let longest = duration * sound_speed / (self.radius * PULSES_PER_CONTACT);
        // The pulses short enough for the contact, and at least one.
        let fitting = self.fields.partition_point(|f| f.pulse <= longest * (1.0 + 1e-9));
        &self.fields[fitting.max(1) - 1]
    }

    /// The sound of a contact, at `rate` samples per second.
    ///
    /// # Errors
    /// Numbers that are not finite, a listener inside the bounding sphere.
    pub fn render(
        &self,
        contact: &HeardContact,
        medium: &Medium,
        rate: f64,
    ) -> Result<RenderedContact, PanError> {
        let tau = contact.duration;
        let shape = |time: f64| (std::f64::consts::PI * time / tau).sin();
        self.render_course(
            contact,
            &ForceWindow { from: 0.0, to: tau, shape: &shape },
            medium,
            rate,
            OUTPUT_BAND * rate,
        )
    }

    /// The sound of a contact with another time profile, at `rate` samples per second, without components
    /// above `highest` \[Hz\], at most [`OUTPUT_BAND`] of the rate.
    ///
    /// # Errors
    /// Numbers that are not finite, a listener inside the bounding sphere.
    pub fn render_course(
        &self,
        contact: &HeardContact,
        window: &ForceWindow<'_>,
        medium: &Medium,
        rate: f64,
        highest: f64,
    ) -> Result<RenderedContact, PanError> {
        let HeardContact { peak, onset, duration, listener } = *contact;
        let Medium { density, sound_speed } = *medium;
        check("the output rate", rate, rate > 0.0)?;
        check("the density", density, density > 0.0)?;
        check("the speed of sound", sound_speed, sound_speed > 0.0)?;
        check("the duration of the contact", duration, duration > 0.0)?;
        check("the onset of the contact", onset, true)?;
        let distance = listener.length();
        check("the distance of the listener", distance, true)?;
        for value in peak {
            check("an acceleration", value, true)?;
        }
        if distance < self.radius {
            return Err(PanError::ListenerInside { distance, radius: self.radius });
        }

        let field = self.field(duration, sound_speed);
        let unit = self.radius / sound_speed;
        let ForceWindow { from, to, shape } = *window;
        check("the extent of the contact", to - from, to > from)?;
        let extent = (to - from) / unit + field.step * field.length as f64;
        let samples = extent * (rate * unit).max(1.0 / field.step).max(1.0 / field.pulse);
        if samples.is_nan() || samples > MOST {
            return Err(PanError::TooLong { duration, samples });
        }
        let [ax, ay, az, bx, by, bz] = peak;
        let z = [ax, ay, az, self.radius * bx, self.radius * by, self.radius * bz];
        let mut response = field.response(&z, listener / self.radius, rate * unit);
        response.trim(SILENCE);
        let h = field.pulse * unit;
        let weights: Vec<f64> = (0..=((to - from) / h) as usize)
            .map(|k| density * self.radius * shape(from + k as f64 * h))
            .collect();
        let mut sum = response.shifted_sum(&weights, field.pulse);
        sum.start = onset + from + distance / sound_speed + sum.start * unit;
        sum.step *= unit;
        let cutoff = highest.min(OUTPUT_BAND / sum.step);
        let (first, samples) = sum.resampled(rate, cutoff);
        Ok(RenderedContact { first, samples })
    }
}

fn check(what: &'static str, value: f64, holds: bool) -> Result<(), PanError> {
    if holds && value.is_finite() { Ok(()) } else { Err(PanError::BadNumber { what, value }) }
}
