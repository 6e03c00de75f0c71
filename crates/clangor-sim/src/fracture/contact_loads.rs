//! Contact loads: the impacts of a step as forces on breakable bodies.
//!
//! ```text
//! history          F(t), U(t) of the solved contact     all instants of the impact
//! half-sine peak   F = (π/2) j/τ,  E = ½ m V²           one instant, as with rigid bodies
//! step             F = j/Δt                             one instant, [FRAC]
//!                  ΔE = ½ j V (1 − e)
//! ```
//!
//! j is the impulse at each point, τ Hertz's duration, m the effective mass, V the approach speed, e the
//! restitution. The forces of a history come from the solve that moved the bodies, if there was one,
//! otherwise from one of these two bodies without vibration ([`pair_histories`]). E is the largest strain
//! energy that the impact can cause in a body, ΔE the energy that motion loses: what the dynamics does not
//! give back, in contacts and, of solved impacts, in the vibration of the body.
//!
//! Differs: \[FRAC\] uses the force j/Δt, which grows as steps shrink.

use std::f64::consts::FRAC_PI_2;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{
    ContactError, ContactSettings, ForceSettings, ImpactPulse, LoadHistory, PoseHistory, impact_pulses,
};
use clangor_core::material::PairCoefficients;
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactRow, PoseRow};
use glam::DVec3;

use crate::record::MERGE_WINDOW;
use crate::rigid::{Impulse, SolvedLoad, StepLog};

/// The load of one impact on one body.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ContactLoad {
    /// Number of the impact: the loads on its bodies share the energy that it loses.
    pub(super) impact: u64,
    /// First instant \[s\].
    pub(super) onset: f64,
    /// End of the load \[s\].
    pub(super) end: f64,
    /// Forces in the axes of the body, at points about its centre of mass.
    pub(super) felt: Felt,
    /// Those points \[m\], world; of a load over time.
    pub(super) places: Vec<DVec3>,
    /// Largest strain energy that it can cause \[J\].
    pub(super) energy: f64,
    /// Energy that the motion of all bodies loses in contacts \[J\].
    pub(super) heat: f64,
    /// Energy that the modes of the body have after it \[J\].
    pub(super) ringing: f64,
}

/// Forces of an impact on a body.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Felt {
    /// Points \[m\] and forces \[N\] at the one instant that counts.
    Once(Vec<(DVec3, DVec3)>),
    /// Forces and stored energy over time.
    OverTime(LoadHistory),
}

impl Felt {
    /// Forces over time on a body at a pose, from world to the axes of the body.
    fn over_time(history: LoadHistory, pose: &Pose) -> Self {
        let to_body = pose.orientation.inverse();
        Felt::OverTime(LoadHistory {
            points: history.points.iter().map(|point| pose.body_from_world(*point)).collect(),
            forces: history.forces.iter().map(|force| to_body * *force).collect(),
            ..history
        })
    }
}

impl ContactLoad {
    /// The shares of this step's impulses on a body that act after a time \[s\].
    pub(super) fn cut_at(&self, time: f64, body: BodyId, log: &StepLog) -> Vec<(usize, f64)> {
        let Felt::OverTime(history) = &self.felt else { return Vec::new() };
        let shares = history.shares_after(time - self.onset);
        let own = |(_, impulse): &(usize, &Impulse)| {
            let row = &impulse.row;
            (row.body_a == body || row.body_b == body) && row.time == self.onset
        };
        let share_of = |(place, impulse): (usize, &Impulse)| {
            let distance = |point: &DVec3| point.distance_squared(impulse.row.point);
            let nearest =
                self.places.iter().zip(&shares).min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
            nearest.filter(|(_, share)| **share > 0.0).map(|(_, share)| (place, *share))
        };
        log.impulses().iter().enumerate().filter(own).filter_map(share_of).collect()
    }

    /// Ends the load at a time \[s\].
    pub(super) fn end_at(&mut self, time: f64) {
        if let Felt::OverTime(history) = &mut self.felt {
            history.end_at(time - self.onset);
            self.end = self.end.min(time);
        }
    }

    /// The load of an impact that moved its bodies by a solve of the contacts.
    pub(super) fn of_solved(load: &SolvedLoad, impact: u64) -> Self {
        let SolvedLoad { state, history, .. } = load;
        let pose = Pose { position: state.position, orientation: state.orientation };
        ContactLoad {
            impact,
            onset: state.time,
            end: state.time + history.duration(),
            places: history.points.clone(),
            felt: Felt::over_time(history.clone(), &pose),
            energy: history.energy,
            heat: history.heat,
            ringing: history.ringing,
        }
    }
}

/// An impact of two bodies as rigid dynamics has it.
#[derive(Clone, Copy)]
pub(super) struct PairImpact<'a> {
    /// A and B; `None` for the world.
    pub(super) bodies: [Option<&'a Body>; 2],
    /// Its rows at one instant, and the poses of its moving bodies before them.
    pub(super) rows: &'a [ContactRow],
    pub(super) poses: &'a [PoseRow],
    /// Its number.
    pub(super) number: u64,
}

impl PairImpact<'_> {
    pub(super) fn ids(&self) -> Option<[BodyId; 2]> {
        self.rows.first().map(|row| [row.body_a, row.body_b])
    }

    /// Restitution and friction.
    pub(super) fn coefficients(&self) -> Option<PairCoefficients> {
        match self.bodies {
            [Some(a), Some(b)] => Some(PairCoefficients::of(&a.material, &b.material)),
            [Some(only), None] | [None, Some(only)] => {
                Some(PairCoefficients::of(&only.material, &only.material))
            }
            [None, None] => None,
        }
    }

    /// The force pulse of rigid bodies. `None` if the approach is slower than `v_min` \[m/s\].
    ///
    /// # Errors
    /// [`ContactError`] for numbers that are not finite.
    pub(super) fn pulse(&self, v_min: f64) -> Result<Option<ImpactPulse>, ContactError> {
        let Some(ids) = self.ids() else { return Ok(None) };
        // Hertz's formula needs only these two bodies, renumbered 0 and 1.
        let pair: Vec<Body> = self.bodies.into_iter().flatten().cloned().collect();
        let own = |id: BodyId| match ids.iter().position(|own| *own == id) {
            Some(at) if id != BodyId::WORLD => BodyId(at as u32),
            _ => BodyId::WORLD,
        };
        let renumbered = |row: &ContactRow| ContactRow {
            body_a: own(row.body_a),
            body_b: own(row.body_b),
            impact_id: 1,
            ..*row
        };
        let rows: Vec<ContactRow> = self.rows.iter().map(renumbered).collect();
        let known = self.poses.iter().filter(|pose| ids.contains(&pose.body));
        let poses: Vec<PoseRow> = known.map(|pose| PoseRow { body: own(pose.body), ..*pose }).collect();
        // The load takes the impulse and the duration of rigid bodies.
        let forces = ForceSettings::default().rigid();
        let settings = ContactSettings { v_min, forces, chain_onset: false };
        let (pulses, _) = impact_pulses(&pair, &rows, &PoseHistory::try_new(&pair, &poses)?, &settings)?;
        Ok(pulses.into_iter().next())
    }

    /// The load on one of the two bodies by `pulse`: its history, if there is one, or else its impulses times
    /// `per_impulse` \[1/s\]. `None` if `body` is not part of the impact, or cannot move.
    pub(super) fn load_on(
        &self,
        body: BodyId,
        pulse: &ImpactPulse,
        history: Option<LoadHistory>,
        per_impulse: f64,
    ) -> Option<ContactLoad> {
        let side = self.ids()?.iter().position(|id| *id == body)?;
        let pose = pulse.bodies[side]?.pose;
        let restitution = self.coefficients()?.restitution;
        let loss = |row: &ContactRow| {
            0.5 * row.impulse_n * row.approach_speed() * (1.0 - restitution.at(row.approach_speed()))
        };
        let lost: f64 = self.rows.iter().map(loss).sum();
        let (felt, places, duration) = match history {
            Some(history) => {
                let (duration, places) = (history.duration(), history.points.clone());
                (Felt::over_time(history, &pose), places, duration)
            }
            None => {
                let (to_body, sign) = (pose.orientation.inverse(), if side == 0 { 1.0 } else { -1.0 });
                let local = |(point, impulse): &(DVec3, DVec3)| {
                    (pose.body_from_world(*point), to_body * *impulse * (sign * per_impulse))
                };
                // Impulses are merged into one impact for at least this long.
                let felt = Felt::Once(pulse.points.iter().map(local).collect());
                (felt, Vec::new(), pulse.duration.max(MERGE_WINDOW))
            }
        };
        Some(ContactLoad {
            impact: self.number,
            onset: pulse.time,
            end: pulse.time + duration,
            felt,
            places,
            energy: pulse.approach_energy(),
            heat: lost.max(0.0),
            ringing: 0.0,
        })
    }
}

/// (π/2)/τ: the peak of a half-sine per impulse \[1/s\].
pub(super) fn half_sine_peak(pulse: &ImpactPulse) -> f64 {
    FRAC_PI_2 / pulse.duration
}
