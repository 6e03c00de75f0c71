//! Clusters with balls on rods: their impact through the time of the contacts, at the places where it begins.
//!
//! As in [`pressed`](super::pressed), everything within reach of the impact moves by Hertz's forces. Rods
//! take up the impulses along them. The balls then have their new velocities at the instant and the places of
//! the first touch: a ball on an arc cannot follow steps in space, and moves by V τ, a tenth of a millimetre
//! at 1 m/s, during the contact. Normals and the points of contact stay as they are at the first touch.
//!
//! Not covered: gravity and springs during the contact.

use glam::DVec3;

use super::cluster::{Cluster, Participant};
use super::engine::Engine;
use super::press_laws::SLOWEST;
use super::pressed::REACH;
use crate::spheres::compliant_cluster::{CompliantCluster, Mover, Partner, Press};
use crate::spheres::impact::{self, ImpulsePair};
use crate::spheres::tolerances::TOUCH;

/// Longest course of a cluster, in first contact times.
const LONGEST: f64 = 200.0;

/// A contact of the cluster over its course.
#[derive(Clone, Copy, Default)]
struct PressSum {
    impulse: DVec3,
    fastest: f64,
}

impl Engine {
    /// How far from a member a ball belongs to its cluster \[m\]: 0 where the law of impacts is used.
    pub(super) fn cluster_reach(&self, ball: usize, partner: Participant) -> f64 {
        if self.islands.is_empty() || self.compliance.is_none() {
            return 0.0;
        }
        let approach = self.approach(ball, partner);
        if approach.speed < SLOWEST || !approach.duration.is_finite() {
            return 0.0;
        }
        REACH * approach.speed * approach.duration
    }

    /// Solves a cluster; `false` leaves it as it is, where it is not more than one contact or does not end.
    pub(super) fn press_in_place(&self, cluster: &mut Cluster) -> bool {
        let Some(compliance) = self.compliance.filter(|_| cluster.touches.len() > 1) else { return false };
        let mut system = CompliantCluster::default();
        for (member, at) in cluster.members.iter().zip(&cluster.positions) {
            system.balls.push(Mover {
                position: *at,
                velocity: member.velocity,
                omega: member.omega,
                inverse_mass: member.inverse_mass,
                inverse_inertia: member.inverse_inertia,
                radius: 0.0,
                held: member.held,
            });
        }
        let mut first = f64::INFINITY;
        let approaches = cluster.touches.iter().map(|touch| -touch.normal_speed(&cluster.members));
        let fastest = approaches.fold(0.0, f64::max);
        for touch in &cluster.touches {
            let Participant::Ball(ball) = cluster.participants[touch.a] else { return false };
            system.balls[touch.a].radius = self.balls[ball].radius;
            let (partner, other, gap) = match cluster.participants[touch.b] {
                Participant::Ball(other) => {
                    system.balls[touch.b].radius = self.balls[other].radius;
                    (
                        Partner::Along(touch.b, touch.normal),
                        Participant::Ball(other),
                        self.touch_gap(cluster, touch),
                    )
                }
                Participant::Plane(plane) => {
                    let offset = self.planes[plane].offset;
                    let gap = self.touch_gap(cluster, touch) - offset;
                    (Partner::Plane(touch.normal, offset), Participant::Plane(plane), gap)
                }
            };
            // A contact that is pushed through others meets about as fast as the fastest of them.
            let own = -touch.normal_speed(&cluster.members);
            let meeting = if own > SLOWEST { own } else { fastest };
            let law = self.law_of(ball, other, gap.min(0.0), meeting);
            let speed = own.max(SLOWEST);
            let duration = self.contact_time(&law, self.inverse_mass_of(ball, other), speed);
            if duration > 0.0 {
                first = first.min(duration);
            }
            system.presses.push(Press::new(touch.a, partner, law, -gap));
        }
        let h = first / compliance.steps;
        let Some(courses) = run(&mut system, h, first) else { return false };
        // The impulses of the contacts, as the law of impacts has them.
        cluster.impulse_pairs.clear();
        for (index, (touch, course)) in cluster.touches.iter().zip(&courses).enumerate() {
            if course.impulse == DVec3::ZERO {
                continue;
            }
            let normal = course.impulse.dot(touch.normal);
            let velocity = touch.velocity(&cluster.members);
            let approach = -course.fastest - touch.normal.dot(velocity);
            cluster.impulse_pairs.push(ImpulsePair {
                touch: index,
                normal,
                tangential: course.impulse - touch.normal * normal,
                velocity: velocity + touch.normal * approach,
            });
        }
        for (member, ball) in cluster.members.iter_mut().zip(&system.balls) {
            (member.velocity, member.omega) = (ball.velocity, ball.omega);
        }
        impact::note_rods(&mut cluster.members, &cluster.touches, &cluster.impulse_pairs);
        true
    }

    /// Distance of the surfaces of two balls, or height of a ball over the origin of its plane \[m\].
    fn touch_gap(&self, cluster: &Cluster, touch: &impact::Touch) -> f64 {
        let [a, b] = [touch.a, touch.b].map(|member| self.radius_of(cluster.participants[member]));
        match cluster.participants[touch.b] {
            Participant::Plane(_) => touch.normal.dot(cluster.positions[touch.a]) - a,
            Participant::Ball(_) => cluster.positions[touch.a].distance(cluster.positions[touch.b]) - a - b,
        }
    }

    /// Leaves the touches of a cluster that was gathered with a reach without those that have gaps.
    pub(super) fn drop_gaps(&self, cluster: &mut Cluster) {
        let gaps: Vec<f64> = cluster
            .touches
            .iter()
            .map(|touch| match cluster.participants[touch.b] {
                Participant::Plane(plane) => self.touch_gap(cluster, touch) - self.planes[plane].offset,
                Participant::Ball(_) => self.touch_gap(cluster, touch),
            })
            .collect();
        let mut at = 0;
        // The first touch is that of the event.
        cluster.touches.retain(|_| {
            at += 1;
            at == 1 || gaps[at - 1] <= TOUCH
        });
    }
}

/// Steps of `h` until nothing touches or is about to; `None` if that takes too long.
fn run(system: &mut CompliantCluster, h: f64, first: f64) -> Option<Vec<PressSum>> {
    let mut courses = vec![PressSum::default(); system.presses.len()];
    let most = (LONGEST * first / h) as usize;
    for _ in 0..most {
        system.step(h, DVec3::ZERO);
        let mut over = true;
        for (course, press) in courses.iter_mut().zip(&system.presses) {
            course.impulse += press.impulse;
            if press.normal_impulse > 0.0 {
                course.fastest = course.fastest.max(press.closing);
            }
            over &= press.overlap <= 0.0 && press.overlap + press.closing * first <= 0.0;
        }
        if over {
            return Some(courses);
        }
    }
    None
}
