//! The solver for piles, which is not there yet: nothing makes one.

use clangor::body::{BodyId, World};
use glam::DVec3;

use crate::SimulationError;
use crate::live::BodyState;
use crate::record::Recorder;

/// No value.
pub(crate) enum Stepped {}

impl Stepped {
    pub(crate) fn now(&self) -> f64 {
        match *self {}
    }

    pub(crate) fn step(&mut self, _: &World, _: &mut Recorder<'_>) -> Result<u64, SimulationError> {
        match *self {}
    }

    pub(crate) fn states(&self) -> impl Iterator<Item = (u32, BodyState)> {
        std::iter::empty()
    }

    pub(crate) fn set_velocity(&mut self, _: BodyId, _: DVec3) {
        match *self {}
    }

    pub(crate) fn set_gravity(&mut self, _: DVec3) {
        match *self {}
    }

    pub(crate) fn add(&mut self, _: &World, _: BodyId) {
        match *self {}
    }

    pub(crate) fn remove(&mut self, _: BodyId) {
        match *self {}
    }
}
