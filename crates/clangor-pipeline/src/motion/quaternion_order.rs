//! Whether the quaternions of a recording have their scalar first, found by how bodies spin as they fall.
//!
//! ```text
//! L = R I Rᵀ ω    constant without torque;    ωₖ = log(qₖ₊₁ qₖ⁻¹)/h, L with R halfway
//! ```
//!
//! A quaternion (w, x, y, z) that is read as (x, y, z, w) is a rotation too, and a steady spin stays a steady
//! spin about another axis. Of a body whose moments of inertia differ, that axis is a wrong one: its angular
//! momentum turns about. A fall of seven frames is a sign of the wrong order if L as read varies by more than
//! 10 %, and by less than 2 % with the scalar taken from the front.
//!
//! Falls do not show it of spheres, cubes and other bodies with one moment of inertia only, of bodies that
//! hardly turn, nor of spins about a fixed axis, which engines without gyroscopic torque give to every body.
//! Most recordings begin with a body that is not turned: (1, 0, 0, 0), or half a turn about x as read. Where
//! every body begins so, the order is doubted too.

use clangor_core::glam::{DMat3, DQuat, DVec3};

/// Frames of a fall.
pub(super) const POINTS: usize = 7;
/// Variation of angular momentum from which on it is not constant, and up to which it is.
const VARIES: f64 = 0.1;
const CONSTANT: f64 = 0.02;
/// Smallest change of the direction of the spin \[rad\].
const TUMBLES: f64 = 0.05;
/// Smallest angle of a fall, and largest within a frame of it \[rad\].
const TURN: (f64, f64) = (0.5, 0.5);
/// What (1, 0, 0, 0) is as read, and the differences of its rounding.
const HALF_TURN: DQuat = DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);
const SAME: f64 = 1e-9;
/// Falls that show the wrong order.
const FEWEST: u64 = 3;
/// Falls of a body that are looked at.
const MOST: u64 = 10_000;

/// What the falls of one body say.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuaternionOrder {
    inertia: DMat3,
    /// From the axes of the file to ours.
    turn: DQuat,
    /// Falls in which the scalar comes first.
    first: u64,
    /// Falls in which it comes last.
    last: u64,
    /// Row of the first of the former.
    row: u64,
    /// Falls that were looked at.
    looked_at: u64,
    /// Row of the first frame, and whether it is (1, 0, 0, 0).
    begins: Option<(u64, bool)>,
}

impl QuaternionOrder {
    /// Of a body with this inertia [kg m²], whose file was turned so.
    pub(crate) fn new(inertia: DMat3, turn: DQuat) -> Self {
        QuaternionOrder { inertia, turn, first: 0, last: 0, row: 0, looked_at: 0, begins: None }
    }

    /// Takes the orientation of the first frame, which is in a row.
    pub(super) fn begin(&mut self, orientation: DQuat, row: u64) {
        let as_written = self.turn.inverse() * orientation;
        self.begins = Some((row, as_written.abs_diff_eq(HALF_TURN, SAME)));
    }

    /// The row of the first frame, if that is (1, 0, 0, 0).
    pub(super) fn begins_with_one(&self) -> Option<u64> {
        self.begins.filter(|(_, is_one)| *is_one).map(|(row, _)| row)
    }

    /// Takes times \[s\] and orientations of a fall that ends in a row.
    pub(super) fn push(&mut self, fall: &[(f64, DQuat); POINTS], row: u64) {
        if self.looked_at == MOST {
            return;
        }
        self.looked_at += 1;
        let to_file = self.turn.inverse();
        let scalar_first = fall.map(|(time, orientation)| {
            let DQuat { x, y, z, w } = to_file * orientation;
            (time, DQuat::from_xyzw(y, z, w, x))
        });
        let (Some(read), Some(other)) = (self.spin(fall), self.spin(&scalar_first)) else { return };
        if read.varies > VARIES && read.tumbles > TUMBLES && other.varies < CONSTANT {
            self.row = if self.first == 0 { row } else { self.row };
            self.first += 1;
        } else if read.varies < CONSTANT && other.varies > VARIES {
            self.last += 1;
        }
    }

    /// The row in which the first fall ends, if the falls say that the scalar comes first.
    pub(super) fn scalar_first(&self) -> Option<u64> {
        (self.first >= FEWEST && self.first > 10 * self.last).then_some(self.row)
    }

    fn spin(&self, fall: &[(f64, DQuat); POINTS]) -> Option<Spin> {
        let mut momenta = [DVec3::ZERO; POINTS - 1];
        let mut spins = momenta;
        let mut turn = 0.0;
        for (k, pair) in fall.windows(2).enumerate() {
            let [(t, from), (u, to)] = [pair[0], pair[1]];
            let step = to * from.inverse();
            let angle = (if step.w < 0.0 { -step } else { step }).to_scaled_axis();
            if angle.length() > TURN.1 {
                return None;
            }
            turn += angle.length();
            let halfway = DQuat::from_scaled_axis(0.5 * angle) * from;
            spins[k] = angle / (u - t);
            momenta[k] = halfway * (self.inertia * (halfway.inverse() * spins[k]));
        }
        let mean = momenta.iter().sum::<DVec3>() / momenta.len() as f64;
        let varies =
            momenta.iter().map(|momentum| momentum.distance(mean)).fold(0.0, f64::max) / mean.length();
        let tumbles = spins.iter().map(|spin| spin.angle_between(spins[0])).fold(0.0, f64::max);
        (turn > TURN.0 && varies.is_finite()).then_some(Spin { varies, tumbles })
    }
}

/// The spin in a fall.
struct Spin {
    /// Largest distance of the angular momentum from its mean, over the mean.
    varies: f64,
    /// Largest change of the direction of the angular velocity \[rad\].
    tumbles: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orientations of a body with these moments of inertia that nothing turns, `rate` times a second.
    fn tumbling(moments: DVec3, spin: DVec3, rate: u32, gyroscopic: bool) -> Vec<(f64, DQuat)> {
        let momentum = moments * spin;
        let h = 1.0 / 24_000.0;
        let mut orientation = DQuat::IDENTITY;
        let mut frames = Vec::new();
        let omega = |q: DQuat| q * ((q.inverse() * momentum) / moments);
        for step in 0..12_000_u32 {
            if step.is_multiple_of(24_000 / rate) {
                frames.push((f64::from(step) * h, orientation));
            }
            let now = if gyroscopic { omega(orientation) } else { spin };
            let middle = DQuat::from_scaled_axis(0.5 * h * now) * orientation;
            let turn = if gyroscopic { omega(middle) } else { spin };
            orientation = (DQuat::from_scaled_axis(h * turn) * orientation).normalize();
        }
        frames
    }

    /// Whether half a second of flight says that the scalar comes first.
    fn is_first(moments: DVec3, frames: &[(f64, DQuat)], turn: DQuat) -> bool {
        let mut order = QuaternionOrder::new(DMat3::from_diagonal(moments), turn);
        for stride in [1, 2, 4, 8, 16] {
            for end in (6 * stride..frames.len()).step_by(stride) {
                let fall = std::array::from_fn(|k| frames[end + k * stride - 6 * stride]);
                order.push(&fall, end as u64);
            }
        }
        order.scalar_first().is_some()
    }

    #[test]
    fn a_tumbling_body_tells_the_order() {
        let z_up = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        let mut found = 0;
        let mut count = 0;
        for moments in [DVec3::new(1.0, 2.0, 2.5), DVec3::new(1.0, 1.0, 0.4), DVec3::new(0.3, 1.0, 1.0)] {
            for direction in
                [DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 1.0), DVec3::new(-1.0, 0.5, 0.7)]
            {
                for (rate, speed) in [(60, 5.0), (60, 20.0), (120, 10.0), (1000, 5.0), (1000, 20.0)] {
                    let spin = direction.normalize() * speed;
                    for gyroscopic in [true, false] {
                        let right = tumbling(moments, spin, rate, gyroscopic);
                        let wrong = |turn: DQuat| -> Vec<(f64, DQuat)> {
                            let read = |q: DQuat| turn * DQuat::from_xyzw(q.w, q.x, q.y, q.z);
                            right.iter().map(|(time, q)| (*time, read(*q))).collect()
                        };
                        let what = (moments, direction, rate, speed, gyroscopic);
                        assert!(!is_first(moments, &right, DQuat::IDENTITY), "{what:?}");
                        let turned: Vec<_> = right.iter().map(|(time, q)| (*time, z_up * *q)).collect();
                        assert!(!is_first(moments, &turned, z_up), "{what:?}");
                        let tells = is_first(moments, &wrong(DQuat::IDENTITY), DQuat::IDENTITY);
                        assert_eq!(tells, is_first(moments, &wrong(z_up), z_up), "{what:?}");
                        count += usize::from(gyroscopic);
                        found += usize::from(tells);
                    }
                }
            }
        }
        println!("{found} of {count} tumbling bodies show that the scalar comes first");
        assert!(found * 2 > count, "{found} of {count}");
    }

    #[test]
    fn a_cube_tells_nothing() {
        let frames = tumbling(DVec3::ONE, DVec3::new(5.0, 8.0, 3.0), 120, true);
        let wrong: Vec<_> = frames.iter().map(|(t, q)| (*t, DQuat::from_xyzw(q.w, q.x, q.y, q.z))).collect();
        assert!(!is_first(DVec3::ONE, &wrong, DQuat::IDENTITY));
        assert!(!is_first(DVec3::ONE, &frames, DQuat::IDENTITY));
    }
}
