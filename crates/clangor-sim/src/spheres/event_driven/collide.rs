//! Resolves and logs an impact with the cluster of everything that touches at that instant.

use clangor_core::body::BodyId;
use clangor_core::material::PairRestitution;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::DVec3;

use super::ball::MotionPhase;
use super::cluster::{Cluster, Participant};
use super::engine::Engine;
use super::grid::NONE;
use crate::record::Recorder;
use crate::spheres::impact::{self, Member, Slow, Touch};
use crate::spheres::tolerances::{CONTACT_TIME, TIE, TOUCH};

/// Hits in quick succession that mark an inelastic collapse or a pile.
const QUICK_HITS: u32 = 32;

/// In a pile, approaches up to this multiple of the slowest bounce are stopped: 1 cm/s on Earth, inaudible.
const PILE_STOP: f64 = 40.0;

/// Squared number of touches that costs as much as one further event.
const COSTLY: u64 = 16;

impl Engine {
    /// Resolves the impact of a ball with its partner and everything that they touch.
    pub(super) fn collide(
        &mut self,
        ball: usize,
        partner: Participant,
        recorder: &mut Recorder<'_>,
    ) -> std::io::Result<()> {
        if self.is_crowded(ball, partner) {
            self.impacts += 1;
            return self.begin_press(ball, partner, recorder);
        }
        let mut cluster = std::mem::take(&mut self.cluster);
        cluster.clear();
        let done = self.resolve(&mut cluster, ball, partner, recorder);
        self.impacts += 1;
        self.cluster = cluster;
        done
    }

    fn resolve(
        &mut self,
        cluster: &mut Cluster,
        ball: usize,
        partner: Participant,
        recorder: &mut Recorder<'_>,
    ) -> std::io::Result<()> {
        // Collect the cluster: everything that touches a member, transitively, or is within reach.
        let reach = self.cluster_reach(ball, partner);
        self.add_ball(cluster, ball);
        let other = match partner {
            Participant::Ball(other) => self.add_ball(cluster, other),
            Participant::Plane(plane) => self.add_plane(cluster, plane),
        };
        self.add_touch(cluster, 0, other);
        let mut grown = 0;
        while grown < cluster.participants.len() {
            if let Participant::Ball(ball) = cluster.participants[grown]
                && self.traits[ball].free
            {
                self.add_touching(cluster, grown, ball, reach);
            }
            grown += 1;
        }
        cluster.before.extend(cluster.members.iter().map(|m| (m.velocity, m.omega)));
        // In a pile, slow approaches are stopped without restitution.
        let piled = |participant: &Participant| match *participant {
            Participant::Ball(ball) => self.is_hit_incessantly(ball, 1.5),
            Participant::Plane(_) => false,
        };
        let stop_below = match cluster.touches.len() {
            0 | 1 => 0.0,
            _ if cluster.participants.iter().any(piled) => PILE_STOP * self.slow_speed(),
            _ => 0.0,
        };
        self.set_lifts(cluster, stop_below);
        // Compute and log the impulses.
        self.work += (cluster.touches.len() as u64).pow(2) / COSTLY;
        if reach == 0.0 || !self.press_in_place(cluster) {
            // The law of impacts is for what touches.
            if reach > 0.0 {
                self.drop_gaps(cluster);
            }
            impact::reflect(&mut cluster.members, &cluster.touches, stop_below, &mut cluster.impulse_pairs);
        }
        self.log_impulses(cluster, recorder)?;
        self.apply_velocities(cluster, recorder)?;
        // Predict the next events of the balls that moved.
        let mut again = true;
        for (member, participant) in cluster.members.iter().zip(&cluster.participants) {
            let &Participant::Ball(moved) = participant else { continue };
            if member.moved {
                match self.island_place(moved) {
                    Some((island, _)) => self.predict_island(island),
                    None => self.predict(moved),
                }
                again &= moved != ball;
            }
        }
        if again {
            self.predict(ball);
        }
        Ok(())
    }

    /// Gives the balls their velocities after the impact, and starts their new phases of motion.
    fn apply_velocities(&mut self, cluster: &Cluster, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let mut moved_islands = Vec::new();
        for (member, participant) in cluster.members.iter().zip(&cluster.participants) {
            let &Participant::Ball(ball) = participant else { continue };
            self.traits[ball].member = NONE;
            if member.moved {
                match self.island_place(ball) {
                    Some((island, _)) => self.bring_island_forward(island),
                    None => self.bring_forward(ball),
                }
                self.balls[ball].velocity = member.velocity;
                self.spins[ball].omega = member.omega;
                let traits = &mut self.traits[ball];
                let in_a_row = self.now - traits.last_hit < 1.5 * CONTACT_TIME;
                traits.quick_hits = if in_a_row { traits.quick_hits + 1 } else { 0 };
                traits.last_hit = self.now;
                match self.island_place(ball) {
                    None => self.start_phase(ball, None),
                    Some((island, place)) => {
                        self.log_rods(island, place, member.rod_impulse, recorder)?;
                        moved_islands.push(island);
                    }
                }
            }
        }
        moved_islands.sort_unstable();
        moved_islands.dedup();
        for island in moved_islands {
            self.islands[island].forget_pace();
            self.launch(island);
        }
        Ok(())
    }

    /// Whether a ball has been hit [`QUICK_HITS`] times in a row at intervals of at most 1.5 CONTACT_TIME,
    /// the last time less than `within` times CONTACT_TIME ago.
    fn is_hit_incessantly(&self, ball: usize, within: f64) -> bool {
        let traits = &self.traits[ball];
        traits.quick_hits >= QUICK_HITS && self.now - traits.last_hit < within * CONTACT_TIME
    }

    /// Adds a ball to the cluster. Returns its place.
    fn add_ball(&mut self, cluster: &mut Cluster, ball: usize) -> usize {
        let (position, velocity) = self.state(ball, self.now);
        let spin = &self.spins[ball];
        let island_place = self.island_place(ball);
        let held = island_place
            .map_or([DVec3::ZERO; 2], |(island, place)| self.islands[island].held(place, position));
        let traits = &mut self.traits[ball];
        traits.member = cluster.participants.len() as u32;
        cluster.participants.push(Participant::Ball(ball));
        cluster.positions.push(position);
        cluster.members.push(Member {
            velocity,
            omega: spin.omega + spin.alpha * (self.now - self.balls[ball].time),
            inverse_mass: traits.inverse_mass,
            inverse_inertia: traits.inverse_inertia,
            held,
            rod_impulse: DVec3::ZERO,
            moved: false,
        });
        cluster.participants.len() - 1
    }

    /// Adds a plane to the cluster, with its own copy for each ball. Returns its place.
    fn add_plane(&self, cluster: &mut Cluster, plane: usize) -> usize {
        cluster.participants.push(Participant::Plane(plane));
        cluster.positions.push(DVec3::ZERO);
        cluster.members.push(Member::IMMOVABLE);
        cluster.participants.len() - 1
    }

    /// Adds everything that touches a member, will within [`TIE`], or is nearer than `reach` \[m\].
    fn add_touching(&mut self, cluster: &mut Cluster, member: usize, ball: usize, reach: f64) {
        let (x, v) = (cluster.positions[member], cluster.members[member].velocity);
        let radius = self.balls[ball].radius;
        // A ball that is hit incessantly is in a pile; a wider tolerance synchronises the impacts of the
        // pile.
        let crowded = self.is_hit_incessantly(ball, 1.5);
        let touch = if crowded { TOUCH + self.slow_speed() * CONTACT_TIME } else { TOUCH };
        let touch = touch.max(reach);
        for plane in 0..self.planes.len() {
            let p = &self.planes[plane];
            let gap = p.normal.dot(x) - p.offset - radius;
            let known = |t: &Touch| {
                t.a == member && matches!(cluster.participants[t.b], Participant::Plane(q) if q == plane)
            };
            if gap <= touch + TIE * (-p.normal.dot(v)).max(0.0) && !cluster.touches.iter().any(known) {
                let other = self.add_plane(cluster, plane);
                self.add_touch(cluster, member, other);
            }
        }
        let mut near = std::mem::take(&mut cluster.near);
        near.clear();
        self.for_each_near(ball, |other, record| {
            if record.motion_phase == MotionPhase::Pressed {
                return;
            }
            let (y, w) = if record.motion_phase == MotionPhase::Arc {
                self.state(other, self.now)
            } else {
                record.at(self.now)
            };
            let sum = radius + record.radius;
            let d = x - y;
            let distance_squared = d.length_squared();
            // Rough test without square roots; speeds stay below 1e5 m/s.
            let far = sum + touch + 1e5 * TIE;
            if distance_squared < far * far {
                let distance = distance_squared.sqrt();
                let closing = (-d.dot(v - w) / distance).max(0.0);
                if distance - sum <= touch + TIE * closing {
                    near.push(other);
                }
            }
        });
        for &other in &near {
            let known = self.traits[other].member;
            let theirs = if known == NONE { self.add_ball(cluster, other) } else { known as usize };
            let met = |t: &Touch| (t.a, t.b) == (member, theirs) || (t.a, t.b) == (theirs, member);
            if !cluster.touches.iter().any(met) {
                self.add_touch(cluster, member, theirs);
            }
        }
        cluster.near = near;
    }

    /// Adds the touch of two members; the one with the lower body index is its first.
    fn add_touch(&self, cluster: &mut Cluster, one: usize, two: usize) {
        let body = |member: usize| self.body_of(cluster.participants[member]);
        let plane_last = matches!(cluster.participants[two], Participant::Plane(_)) || body(one) < body(two);
        let (a, b) = if plane_last { (one, two) } else { (two, one) };
        let (Participant::Ball(ball_a), end_b) = (cluster.participants[a], cluster.participants[b]) else {
            return;
        };
        let (normal, arm_b, pressing, when_slow) = match end_b {
            Participant::Plane(plane) => {
                let normal = self.planes[plane].normal;
                if self.balls[ball_a].motion_phase == MotionPhase::Arc {
                    (normal, DVec3::ZERO, -normal.dot(self.acceleration(ball_a)), Slow::Hop)
                } else {
                    (normal, DVec3::ZERO, -normal.dot(self.gravity), Slow::Stay)
                }
            }
            Participant::Ball(ball_b) => {
                let offset = cluster.positions[a] - cluster.positions[b];
                let normal = offset.normalize_or(DVec3::Y);
                let pull = self.acceleration(ball_a) - self.acceleration(ball_b);
                (normal, normal * self.balls[ball_b].radius, -normal.dot(pull), Slow::Hop)
            }
        };
        let material = |participant: Participant| match participant {
            Participant::Ball(ball) => self.traits[ball].material,
            Participant::Plane(plane) => self.planes[plane].material,
        };
        let mut coefficients =
            self.pairs.of(material(cluster.participants[a]), material(cluster.participants[b]));
        if let Participant::Plane(plane) = end_b {
            coefficients = self.planes[plane].met_by(coefficients, self.contact_of(ball_a));
        }
        let lossless = |participant: Participant| match participant {
            Participant::Ball(ball) => !self.traits[ball].free || self.is_hit_incessantly(ball, 0.5),
            Participant::Plane(_) => true,
        };
        if self.gravity == DVec3::ZERO
            && lossless(cluster.participants[a])
            && lossless(cluster.participants[b])
        {
            coefficients.restitution = PairRestitution::LOSSLESS;
        }
        let slow = 0.5 * pressing.max(0.0) * CONTACT_TIME;
        // Balls that have pressed on each other may rest with an overlap; they touch at its middle.
        let radius_a = self.balls[ball_a].radius;
        let (reach, distance) =
            (radius_a + arm_b.length(), cluster.positions[a].distance(cluster.positions[b]));
        let overlaps = self.compliance.is_some() && matches!(end_b, Participant::Ball(_));
        let sunk = if overlaps { (reach - distance).max(0.0) } else { 0.0 };
        let share = radius_a / reach;
        cluster.touches.push(Touch {
            a,
            b,
            normal,
            arm_a: normal * -(radius_a - share * sunk),
            arm_b: arm_b - normal * ((1.0 - share) * sunk),
            coefficients,
            slow,
            when_slow,
            lift: 0.0,
        });
    }

    /// Sets the speeds at which balls that overlap separate.
    fn set_lifts(&self, cluster: &mut Cluster, stop_below: f64) {
        let stops = cluster.touches.iter().all(|t| approach(t, &cluster.members) <= stop_below);
        for touch in 0..cluster.touches.len() {
            cluster.touches[touch].lift = self.lift(cluster, &cluster.touches[touch], stops);
        }
    }

    /// Speed at which two members separate if they overlap \[m/s\].
    ///
    /// Rods and springs may press hung balls harder than gravity does. They are lifted no faster than they
    /// approach, and so gain no energy; where the cluster stops, as fast as they would bounce for
    /// [`CONTACT_TIME`], so that they do not sink into each other.
    fn lift(&self, cluster: &Cluster, touch: &Touch, stops: bool) -> f64 {
        let participants = [touch.a, touch.b].map(|member| cluster.participants[member]);
        let [Participant::Ball(a), Participant::Ball(b)] = participants else { return 0.0 };
        let distance = (cluster.positions[touch.a] - cluster.positions[touch.b]).length();
        let depth = self.balls[a].radius + self.balls[b].radius - distance;
        if depth <= TOUCH {
            return 0.0;
        }
        let mut fastest = self.slow_speed();
        if [a, b].iter().any(|&ball| self.balls[ball].motion_phase == MotionPhase::Arc) {
            let bounce = if stops { touch.slow } else { 0.0 };
            fastest = fastest.max(bounce).min(approach(touch, &cluster.members).max(0.0));
        }
        fastest.min(depth / CONTACT_TIME)
    }

    /// Radius of a ball \[m\]; 0 for a plane.
    pub(super) fn radius_of(&self, participant: Participant) -> f64 {
        match participant {
            Participant::Ball(ball) => self.balls[ball].radius,
            Participant::Plane(_) => 0.0,
        }
    }

    fn body_of(&self, participant: Participant) -> BodyId {
        BodyId(match participant {
            Participant::Ball(ball) => self.traits[ball].body,
            Participant::Plane(plane) => self.planes[plane].body,
        })
    }

    /// Records the rows of each touch.
    fn log_impulses(&self, cluster: &mut Cluster, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let (mut rows, mut poses) = (std::mem::take(&mut cluster.rows), std::mem::take(&mut cluster.poses));
        for (index, touch) in cluster.touches.iter().enumerate() {
            rows.clear();
            poses.clear();
            let radius_a = self.radius_of(cluster.participants[touch.a]);
            let depth = match cluster.participants[touch.b] {
                Participant::Plane(plane) => {
                    let plane = &self.planes[plane];
                    radius_a - (plane.normal.dot(cluster.positions[touch.a]) - plane.offset)
                }
                Participant::Ball(_) => {
                    let distance = cluster.positions[touch.a].distance(cluster.positions[touch.b]);
                    radius_a + self.radius_of(cluster.participants[touch.b]) - distance
                }
            };
            for impulse_pair in cluster.impulse_pairs.iter().filter(|pair| pair.touch == index) {
                rows.push(ContactRow {
                    time: self.now,
                    body_a: self.body_of(cluster.participants[touch.a]),
                    body_b: self.body_of(cluster.participants[touch.b]),
                    kind: ContactKind::Impact,
                    point: cluster.positions[touch.a] + touch.arm_a,
                    normal: touch.normal,
                    impulse_n: impulse_pair.normal,
                    impulse_t: impulse_pair.tangential,
                    couple: DVec3::ZERO,
                    velocity: impulse_pair.velocity,
                    depth,
                    impact_id: 0,
                    effective_mass: None,
                });
            }
            if rows.is_empty() {
                continue;
            }
            for member in [touch.a, touch.b] {
                if let Participant::Ball(ball) = cluster.participants[member]
                    && self.traits[ball].free
                {
                    let s = self.now - self.balls[ball].time;
                    poses.push(PoseRow {
                        time: self.now,
                        body: BodyId(self.traits[ball].body),
                        position: cluster.positions[member],
                        orientation: self.spins[ball].after(s).0,
                        velocity: cluster.before[member].0,
                        angular_velocity: cluster.before[member].1,
                    });
                }
            }
            recorder.impact(&rows, &poses)?;
        }
        (cluster.rows, cluster.poses) = (rows, poses);
        Ok(())
    }
}

/// Speed at which two members approach \[m/s\].
fn approach(touch: &Touch, members: &[Member]) -> f64 {
    -touch.normal.dot(members[touch.a].velocity - members[touch.b].velocity)
}
