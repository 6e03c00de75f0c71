//! Whom the balls that press on each other touch and meet.

use super::cluster::Participant;
use super::engine::Engine;
use super::press_state::{Pressed, Track};
use crate::spheres::compliant_cluster::{Partner, Press, PressLaw};

/// Steps between two searches of neighbours.
const LIST_STEPS: u32 = 16;

impl Engine {
    /// Lists the contacts and neighbours of the members, and takes in those that will be met in this step.
    pub(super) fn gather(&mut self, pressed: &mut Pressed) {
        loop {
            if pressed.countdown == 0 {
                self.list(pressed);
            }
            let h = pressed.step;
            let met = pressed.outsiders.iter().find(|&&(member, other)| {
                let mover = &pressed.cluster.balls[member];
                let x = mover.position + (mover.velocity + self.gravity * (0.5 * h)) * h;
                let (y, _) = self.state(other as usize, self.now + h);
                x.distance(y) <= mover.radius + self.balls[other as usize].radius
            });
            match met {
                Some(&(_, other)) => self.enter(pressed, other as usize),
                None => return,
            }
        }
    }

    /// Lists the contacts and neighbours of the members.
    pub(super) fn list(&mut self, pressed: &mut Pressed) {
        // Pairs that do not touch are listed anew.
        let presses = pressed.cluster.presses.iter().zip(&pressed.tracks);
        let known: Vec<bool> = presses
            .map(|(press, track)| track.open.is_some() || matches!(press.partner, Partner::Support(_)))
            .collect();
        pressed.retain(&vec![true; pressed.members.len()], &known);
        let fastest = pressed.cluster.balls.iter().map(|b| b.velocity.length()).fold(0.0, f64::max);
        let margin = |speed: f64| 2.0 * f64::from(LIST_STEPS) * pressed.step * (2.0 * fastest + speed);
        let (mut near_balls, mut near_planes) = (Vec::new(), Vec::new());
        pressed.outsiders.clear();
        for (member, &ball) in pressed.members.iter().enumerate() {
            if !self.traits[ball as usize].free {
                continue;
            }
            let mover = &pressed.cluster.balls[member];
            for (index, plane) in self.planes.iter().enumerate() {
                let gap = plane.normal.dot(mover.position) - plane.offset - mover.radius;
                if gap < margin(0.0) && !pressed.is_on_plane(member, index) {
                    near_planes.push((member, index, gap));
                }
            }
            self.for_each_near(ball as usize, |other, record| {
                let (y, w) = record.at(self.now);
                let gap = mover.position.distance(y) - mover.radius - record.radius;
                if gap < margin(w.length()) {
                    match pressed.members.iter().position(|&b| b as usize == other) {
                        Some(theirs) => near_balls.push((member.min(theirs), member.max(theirs), gap)),
                        None => pressed.outsiders.push((member, other as u32)),
                    }
                }
            });
        }
        // Contacts in the order of the members, whatever the order of the cells.
        near_balls.sort_by_key(|&(one, two, _)| (one, two));
        near_balls.dedup_by_key(|&mut (one, two, _)| (one, two));
        for (one, two, gap) in near_balls {
            if !pressed.is_listed(one, two) {
                let [a, b] = [one, two].map(|member| pressed.members[member] as usize);
                let law = self.law_of_balls(a, b, gap.min(0.0), pressed.speed);
                let inverse_mass = self.inverse_mass_of(a, Participant::Ball(b));
                self.add_press(pressed, (one, Partner::Ball(two)), None, (law, inverse_mass, gap));
            }
        }
        for (member, index, gap) in near_planes {
            let ball = pressed.members[member] as usize;
            let law = self.law_on_plane(ball, index, gap.min(0.0), pressed.speed);
            let plane = &self.planes[index];
            let partner = Partner::Plane(plane.normal, plane.offset);
            let inverse_mass = self.traits[ball].inverse_mass;
            self.add_press(pressed, (member, partner), Some(index), (law, inverse_mass, gap));
        }
        pressed.outsiders.sort_unstable();
        pressed.countdown = LIST_STEPS;
    }

    pub(super) fn add_press(
        &self,
        pressed: &mut Pressed,
        (member, partner): (usize, Partner),
        plane: Option<usize>,
        (law, inverse_mass, gap): (PressLaw, f64, f64),
    ) {
        let duration = self.contact_time(&law, inverse_mass, pressed.speed);
        let steps = self.compliance.map_or(1.0, |c| c.steps);
        if duration > 0.0 {
            pressed.step = pressed.step.min(duration / steps);
        }
        pressed.cluster.presses.push(Press::new(member, partner, law, -gap.max(0.0)));
        pressed.tracks.push(Track { plane, open: None });
    }
}
