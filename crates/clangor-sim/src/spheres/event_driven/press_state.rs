//! The balls that press on each other at a time, and their contacts.

use clangor_core::timeline::{ContactRow, PoseRow};
use glam::DVec3;

use crate::spheres::compliant_cluster::{CompliantCluster, Partner};

/// How impacts among several balls are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Compliance {
    /// Steps per contact time.
    pub(crate) steps: f64,
}

/// The balls that press on each other now.
#[derive(Default)]
pub(super) struct Pressed {
    /// Balls, in the order of the cluster.
    pub(super) members: Vec<u32>,
    /// Whether a member has made no step yet.
    pub(super) fresh: Vec<bool>,
    pub(super) cluster: CompliantCluster,
    /// Contacts, in the order of the cluster.
    pub(super) tracks: Vec<Track>,
    /// Balls near a member that are not members.
    pub(super) outsiders: Vec<(usize, u32)>,
    /// Time of the records of the members \[s\].
    pub(super) time: f64,
    /// Steps until neighbours are sought again.
    pub(super) countdown: u32,
    /// Step \[s\].
    pub(super) step: f64,
    /// Largest approach speed at which a contact began \[m/s\].
    pub(super) speed: f64,
}

/// What is known of a contact besides its forces.
#[derive(Clone, Default)]
pub(super) struct Track {
    /// Index of the plane, if it is one.
    pub(super) plane: Option<usize>,
    /// What is logged of it, from its onset on.
    pub(super) open: Option<OpenContact>,
}

/// A contact from its onset on.
#[derive(Clone)]
pub(super) struct OpenContact {
    pub(super) row: ContactRow,
    pub(super) poses: Vec<PoseRow>,
    pub(super) impulse: DVec3,
    pub(super) fastest: f64,
    /// Steps for which it has been at rest.
    pub(super) quiet: u32,
    /// Rows of the steps, for the raw log.
    pub(super) rows: Vec<ContactRow>,
}

impl Pressed {
    /// Renumbers the balls.
    pub(super) fn renumber(&mut self, new_of: &[u32]) {
        self.members.iter_mut().for_each(|ball| *ball = new_of[*ball as usize]);
        self.outsiders.iter_mut().for_each(|(_, ball)| *ball = new_of[*ball as usize]);
    }

    /// When the earliest of the contacts that last began \[s\]; infinite without any.
    pub(super) fn first_onset(&self) -> f64 {
        let open = self.tracks.iter().filter_map(|track| track.open.as_ref());
        open.map(|open| open.row.time).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn is_listed(&self, one: usize, two: usize) -> bool {
        self.cluster.presses.iter().any(|press| match press.partner {
            Partner::Ball(other) => (press.ball, other) == (one, two) || (press.ball, other) == (two, one),
            _ => false,
        })
    }

    pub(super) fn is_on_plane(&self, member: usize, plane: usize) -> bool {
        let pairs = self.cluster.presses.iter().zip(&self.tracks);
        pairs.into_iter().any(|(press, track)| press.ball == member && track.plane == Some(plane))
    }

    /// Removes the contacts and members that `stays` rejects.
    pub(super) fn retain(&mut self, stays: &[bool], press_stays: &[bool]) {
        let mut new_of = Vec::with_capacity(stays.len());
        let mut count = 0;
        for stay in stays {
            new_of.push(count);
            count += usize::from(*stay);
        }
        let keep = |flags: &[bool], at: &mut usize| {
            *at += 1;
            flags[*at - 1]
        };
        let mut at = 0;
        self.members.retain(|_| keep(stays, &mut at));
        at = 0;
        self.fresh.retain(|_| keep(stays, &mut at));
        at = 0;
        self.cluster.balls.retain(|_| keep(stays, &mut at));
        at = 0;
        self.tracks.retain(|_| keep(press_stays, &mut at));
        at = 0;
        self.cluster.presses.retain(|_| keep(press_stays, &mut at));
        for press in &mut self.cluster.presses {
            press.ball = new_of[press.ball];
            if let Partner::Ball(other) = &mut press.partner {
                *other = new_of[*other];
            }
        }
        self.countdown = 0;
    }
}
