//! The forces of a session's impacts, kept in a timeline.

use std::path::Path;

use super::source::Motion;
use super::{Error, Session};
use crate::formats::timeline_file::TimelineReader;
use crate::stages::render::timeline_forces;

impl Session<'_> {
    /// Writes the timeline with the forces of its impacts over time into a folder; with `replace`, in place
    /// of an older one, which may be the timeline itself. Simulates and obtains models first. Returns the
    /// number of forces. Rendering that folder gives the same sound without a solve.
    ///
    /// # Errors
    /// [`Error::NotRecorded`] for a scene whose timeline is not kept
    /// ([`SessionBuilder::keep_timeline`](super::SessionBuilder::keep_timeline)); [`Error`]. What was there
    /// before is then untouched.
    pub fn save_forces(&mut self, folder: impl AsRef<Path>, replace: bool) -> Result<u64, Error> {
        if matches!(self.source.motion, Motion::Scene(_)) && self.keep.is_none() {
            return Err(Error::NotRecorded);
        }
        self.obtain_models()?;
        let (Some(motion), Some(models)) = (&self.motion, &self.models) else {
            return Err(Error::Interrupted);
        };
        let forces = timeline_forces(&self.source.bodies, &models.bodies, &motion.timeline, &self.options)?;
        let kept;
        let reader = match (&self.source.motion, &self.keep) {
            (Motion::Timeline(reader), _) => reader,
            (Motion::Scene(_), Some((path, _))) => {
                kept = Box::new(TimelineReader::open(path)?);
                &kept
            }
            (Motion::Scene(_), None) => return Err(Error::NotRecorded),
        };
        Ok(reader.copy_with_forces(&forces, folder.as_ref(), replace)?.forces)
    }
}
