//! A timeline with forces, from one without.

use std::path::Path;

use clangor_core::body::{Body, Life};
use clangor_core::timeline::ForceRow;

use super::error::TimelineError;
use super::reader::TimelineReader;
use super::summary::TimelineSummary;
use super::writer::TimelineWriter;

impl TimelineReader {
    /// Writes this timeline with these forces, in order of time, in place of those that it has. An existing
    /// folder is replaced only if `replace`; it may be that of this timeline.
    ///
    /// # Errors
    /// [`TimelineError`]; what was there before is then untouched.
    pub fn copy_with_forces(
        &self,
        forces: &[ForceRow],
        folder: &Path,
        replace: bool,
    ) -> Result<TimelineSummary, TimelineError> {
        let has_effective_mass = self.has_effective_mass()?;
        let mut writer =
            TimelineWriter::create_for_contacts(folder, self.header(), replace, has_effective_mass)?;
        let mut births = self.births();
        for fracture in self.fractures() {
            let (pieces, later) = births.split_at((fracture.children as usize).min(births.len()));
            // A piece that breaks later does not know of it as it is born.
            let born =
                |piece: &Body| Body { life: Life { death: f64::INFINITY, ..piece.life }, ..piece.clone() };
            writer.replace(fracture, &pieces.iter().map(born).collect::<Vec<_>>())?;
            births = later;
        }
        for contact in self.contacts()? {
            writer.add_contact(&contact?)?;
        }
        for pose in self.poses()? {
            writer.add_pose(&pose?)?;
        }
        for force in forces {
            writer.force(force)?;
        }
        writer.finish()
    }
}
