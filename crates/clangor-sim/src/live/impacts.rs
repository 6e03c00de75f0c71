//! Force pulses of the impacts of a live world, returned as soon as they are final.

use std::mem::take;

use clangor_core::body::Body;
use clangor_core::contact::chain_onset::delay_chains_after;
use clangor_core::contact::{
    ContactError, ContactSettings, ForceSettings, ImpactPulse, PoseHistory, impact_pulses,
};
use clangor_core::timeline::{ContactRow, PoseRow, Timeline};

use super::error::LiveError;
use crate::SimulationError;
use crate::record::{RecordSettings, Recorder, Suspended};

/// How long earlier pulses are kept for the delays of impact chains \[s\]: longer than any impact of a
/// sphere.
const MEMORY: f64 = 0.02;

/// Impacts between the solver and the caller.
pub(super) struct Impacts {
    settings: RecordSettings,
    open: Suspended,
    /// Rows of ended impacts; times are those of the solver's clock.
    over: Timeline,
    /// Recently fetched pulses, then pulses that have not been fetched.
    pulses: Vec<ImpactPulse>,
    /// Number of fetched pulses in `pulses`.
    fetched: usize,
    log: Vec<ContactRow>,
}

impl Impacts {
    pub(super) fn new(v_min: f64, log: bool) -> Self {
        Impacts {
            settings: RecordSettings { v_min, pose_rate: 0.0, raw: log },
            open: Suspended::default(),
            over: Timeline::default(),
            pulses: Vec::new(),
            fetched: 0,
            log: Vec::new(),
        }
    }

    /// Runs a solver with a recorder.
    pub(super) fn record<T>(
        &mut self,
        run: impl FnOnce(&mut Recorder<'_>) -> Result<T, SimulationError>,
    ) -> Result<T, SimulationError> {
        let mut recorder = Recorder::resume(self.settings, take(&mut self.open), &mut self.over);
        let outcome = run(&mut recorder);
        self.open = recorder.suspend();
        outcome
    }

    /// Computes the pulses of all impacts that can no longer change at `time` on the solver's clock, which
    /// started at `origin` \[s\].
    pub(super) fn close(&mut self, bodies: &[Body], time: f64, origin: f64) -> Result<(), LiveError> {
        self.record(|recorder| Ok(recorder.advance(time)?))?;
        if self.over.contacts.is_empty() {
            return Ok(());
        }
        let Timeline { contacts, poses, .. } = take(&mut self.over);
        let contacts: Vec<ContactRow> =
            contacts.into_iter().map(|row| ContactRow { time: row.time + origin, ..row }).collect();
        let poses: Vec<PoseRow> =
            poses.into_iter().map(|row| PoseRow { time: row.time + origin, ..row }).collect();
        Ok(self.append_pulses(bodies, contacts, &poses)?)
    }

    /// Appends the force pulses of ended impacts, and their rows to the log.
    fn append_pulses(
        &mut self,
        bodies: &[Body],
        rows: Vec<ContactRow>,
        poses: &[PoseRow],
    ) -> Result<(), ContactError> {
        let audible: Vec<ContactRow> = rows.iter().filter(|row| row.impact_id > 0).copied().collect();
        if self.settings.raw {
            self.log.extend(rows);
        }
        let settings = ContactSettings {
            v_min: self.settings.v_min,
            forces: ForceSettings::default().live(),
            chain_onset: false,
        };
        let history = PoseHistory::try_new(bodies, poses)?;
        let (mut pulses, _) = impact_pulses(bodies, &audible, &history, &settings)?;
        // The order in which simultaneous impacts were closed depends on the division of time.
        pulses.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.pair.cmp(&b.pair)));
        // Drop old pulses; delay the chains of the new ones.
        if let Some(first) = pulses.first() {
            let since = first.time - MEMORY;
            let old = self.pulses[..self.fetched].iter().take_while(|pulse| pulse.time < since).count();
            self.pulses.drain(..old);
            self.fetched -= old;
            let known = self.pulses.len();
            self.pulses.extend(pulses);
            delay_chains_after(&mut self.pulses, known);
        }
        Ok(())
    }

    /// Pulses that have not been fetched.
    pub(super) fn ready(&self) -> &[ImpactPulse] {
        &self.pulses[self.fetched..]
    }

    /// Marks all pulses as fetched.
    pub(super) fn clear(&mut self) {
        self.fetched = self.pulses.len();
    }

    pub(super) fn take_log(&mut self) -> Vec<ContactRow> {
        take(&mut self.log)
    }
}
