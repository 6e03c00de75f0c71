//! The ranges of numbers that are accepted in scenes, timelines, sound models and contact lists.
//!
//! The bounds lie outside what is physical, and inside what the formulas compute without overflow.

/// A quantity: its unit and its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    unit: &'static str,
    low: f64,
    high: f64,
    low_excluded: bool,
}

impl Quantity {
    /// A component of a vector, bounded so that squares and cubes of lengths do not overflow.
    pub const fn coordinate(unit: &'static str) -> Self {
        Quantity::between(-1e5, 1e5, unit)
    }

    /// Any finite number.
    pub const fn any(unit: &'static str) -> Self {
        Quantity { unit, low: f64::NEG_INFINITY, high: f64::INFINITY, low_excluded: false }
    }

    /// Within two bounds, which are allowed.
    pub const fn between(low: f64, high: f64, unit: &'static str) -> Self {
        Quantity { unit, low, high, low_excluded: false }
    }

    /// Above a bound and up to another.
    pub const fn above(low: f64, high: f64, unit: &'static str) -> Self {
        Quantity { unit, low, high, low_excluded: true }
    }

    /// Whether a number is within the range; NaN is not.
    pub fn admits(&self, value: f64) -> bool {
        value <= self.high && if self.low_excluded { value > self.low } else { value >= self.low }
    }

    /// Its unit; empty for a ratio.
    pub const fn unit(&self) -> &'static str {
        self.unit
    }

    /// Description in words.
    pub fn expected(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" in {}", self.unit) };
        let range = match (self.low, self.high) {
            (f64::NEG_INFINITY, f64::INFINITY) => String::new(),
            (low, high) if self.low_excluded => {
                format!(" above {} and up to {}", readable(low), readable(high))
            }
            (low, high) => format!(" from {} to {}", readable(low), readable(high)),
        };
        format!("a number{unit}{range}")
    }
}

/// Density of a solid.
pub const DENSITY: Quantity = Quantity::between(1e-3, 1e5, "kg/m³");
/// Young's modulus.
pub const MODULUS: Quantity = Quantity::between(1.0, 1e13, "Pa");
/// Poisson's ratio: the open interval of isotropic elasticity, a hair inside. At 0.5 a body is
/// incompressible.
pub const POISSON: Quantity = Quantity::between(-0.999, 0.4999, "");
/// Restitution.
pub const RESTITUTION: Quantity = Quantity::between(0.0, 1.0, "");
/// Speed at which a restitution holds.
pub const RESTITUTION_SPEED: Quantity = Quantity::between(1e-6, 1e3, "m/s");
/// Yield or tensile strength.
pub const STRENGTH: Quantity = Quantity::between(1.0, 1e13, "Pa");
/// Coefficient of friction.
pub const FRICTION: Quantity = Quantity::between(0.0, 10.0, "");
/// Length by which rolling resistance leads.
pub const ROLLING_LOSS: Quantity = Quantity::between(0.0, 1.0, "m");
/// Energy of new surface.
pub const FRACTURE_ENERGY: Quantity = Quantity::between(1e-6, 1e9, "J/m²");
/// Density of a medium.
pub const MEDIUM_DENSITY: Quantity = Quantity::between(1e-6, 1e5, "kg/m³");
/// Speed of sound.
pub const SOUND_SPEED: Quantity = Quantity::between(10.0, 2e4, "m/s");
/// Duration of a simulation.
pub const DURATION: Quantity = Quantity::between(1e-3, 3600.0, "s");
/// Step of a simulation.
pub const TIME_STEP: Quantity = Quantity::between(1e-6, 0.01, "s");
/// Least approach speed of an impact.
pub const V_MIN: Quantity = Quantity::between(0.0, 1e3, "m/s");
/// Poses recorded in a second.
pub const POSE_RATE: Quantity = Quantity::between(1.0, 1e5, "Hz");
/// Lower bound of the local contact radius.
pub const EDGE_RADIUS: Quantity = Quantity::between(1e-9, 1e3, "m");
/// Force with which a guided body presses.
pub const PRESS: Quantity = Quantity::between(1e-9, 1e9, "N");
/// Thickness of an endless plate.
pub const THICKNESS: Quantity = Quantity::between(1e-5, 10.0, "m");
/// Bounding radius of a body.
pub const RADIUS: Quantity = Quantity::between(1e-6, 1e3, "m");
/// Mass of a body that is not infinite.
pub const MASS: Quantity = Quantity::above(0.0, 1e18, "kg");
/// Effective mass of two bodies at a contact.
pub const EFFECTIVE_MASS: Quantity = Quantity::between(1e-30, 1e18, "kg");
/// Volume of a body.
pub const VOLUME: Quantity = Quantity::above(0.0, 1e10, "m³");
/// Duration of a timeline, which may be a long recording.
pub const TIMELINE_DURATION: Quantity = Quantity::between(0.0, 1e5, "s");
/// Step of a timeline; 0 where nothing was stepped.
pub const TIMELINE_STEP: Quantity = Quantity::between(0.0, 1.0, "s");
/// Poses of a timeline in a second; 0 where there is none but at impacts.
pub const TIMELINE_POSE_RATE: Quantity = Quantity::between(0.0, 1e6, "Hz");
/// Stiffness of a spring.
pub const STIFFNESS: Quantity = Quantity::between(1e-9, 1e12, "N/m");
/// Damping of a spring.
pub const SPRING_DAMPING: Quantity = Quantity::between(0.0, 1e12, "N s/m");
/// Length of a spring without force.
pub const REST_LENGTH: Quantity = Quantity::between(0.0, 1e5, "m");
/// Frequency of a mode, or the highest of a model.
pub const FREQUENCY: Quantity = Quantity::between(1e-3, 1e9, "Hz");
/// Rate at which the dampers of supports take the energy of a mode.
pub const DAMPING_RATE: Quantity = Quantity::between(0.0, 1e9, "1/s");
/// Relative error that is asked of a model.
pub const ACCURACY: Quantity = Quantity::above(0.0, 1e6, "");
/// Highest wavenumber of a field, over the bounding radius.
pub const WAVENUMBER: Quantity = Quantity::between(1e-9, 1e6, "");
/// Time for which a field rings on, over that of sound along the bounding radius.
pub const RING_TIME: Quantity = Quantity::between(0.0, 1e6, "");
/// Place of a node of a field in the plane of complex frequencies, over c/R.
pub const NODE: Quantity = Quantity::between(0.0, 1e7, "");
/// Weight of a node of a field.
pub const NODE_WEIGHT: Quantity = Quantity::between(0.0, 1e30, "");
/// Component of a multipole, of a pressure or of a shape.
pub const COMPONENT: Quantity = Quantity::between(-1e20, 1e20, "");
/// Component of an impulse.
pub const IMPULSE: Quantity = Quantity::between(-1e12, 1e12, "N s");
/// Component of a couple over time.
pub const ANGULAR_IMPULSE: Quantity = Quantity::between(-1e12, 1e12, "N m s");
/// Component of a velocity.
pub const VELOCITY: Quantity = Quantity::coordinate("m/s");
/// Component of a position.
pub const COORDINATE: Quantity = Quantity::coordinate("m");

/// Digits of a length in a message.
const LENGTH_DIGITS: i32 = 2;

/// A length \[m\] in mm, cm or m, to two digits and without an exponent: "1.1 cm".
pub fn readable_length(metres: f64) -> String {
    let (unit, scale) = match metres.abs() {
        size if size >= 1.0 => ("m", 1.0),
        size if size >= 0.01 => ("cm", 100.0),
        _ => ("mm", 1000.0),
    };
    let value = scale * metres;
    let order = value.abs().log10().floor();
    let decimals = if order.is_finite() { (LENGTH_DIGITS - 1 - order as i32).max(0) } else { 0 };
    format!("{value:.*} {unit}", decimals as usize)
}

/// A computed number to so many significant digits, at least one.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.max(1) - 1).parse().unwrap_or(value)
}

/// A number without trailing zeros.
pub fn readable(value: f64) -> String {
    let plain = value == 0.0 || (1e-4..1e7).contains(&value.abs()) || !value.is_finite();
    if plain { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_computed_number_shows_few_digits() {
        let values = [30.265_492_902_591_97, 0.000_412_345, -123_456.0, 0.0, f64::INFINITY, 1e-300, 1e300];
        let shown = values.map(|value| readable(rounded(value, 4)));
        assert_eq!(shown, ["30.27", "0.0004123", "-123500", "0", "inf", "1e-300", "1e300"]);
    }

    #[test]
    fn a_length_has_a_unit_of_its_size() {
        let shown = [1.084e-2, 3.3e-3, 1.2e-6, 0.5, 12.34, -0.02, 0.0].map(readable_length);
        assert_eq!(shown, ["1.1 cm", "3.3 mm", "0.0012 mm", "50 cm", "12 m", "-2.0 cm", "0 mm"]);
    }
}
