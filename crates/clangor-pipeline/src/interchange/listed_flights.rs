//! Which bodies of a scene fly by a contact list, and which notices say so.
//!
//! Free bodies with a row fly, unless a link or a support holds them. A body whose flight leads past one of
//! its listed impacts by more than its own size is not where the list has it: it stays where the scene starts
//! it, and so its sound is that of the impacts alone.

use clangor_core::body::{BodyId, Motion, World};
use clangor_core::timeline::{ContactRow, TimelineSink};

use crate::formats::timeline_file::TimelineWriter;
use crate::motion::contact_checks::surface_tolerance;
use crate::motion::flights::{Disagreement, PoseClock, fly};
use crate::stages::load::LoadedScene;

/// Poses in a second where the scene writes none.
const DEFAULT_RATE: f64 = 1000.0;
/// Difference of approaches from which a notice is given, as a share of the listed one. Simulators with steps
/// of a millisecond are within 1 % at 1 m/s.
const APPROACH_TOLERANCE: f64 = 0.05;

/// The flights of a list.
pub(super) struct ListedFlights {
    clock: PoseClock,
    bodies: Vec<Flown>,
    disagreements: Vec<Disagreement>,
    /// Approaches of the rows [m/s].
    approaches: Vec<f64>,
}

/// What becomes of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Flown {
    /// It does not move freely, or has no row.
    Unlisted,
    /// Something holds it.
    Held,
    Flies,
    /// Its flight leads elsewhere.
    Strays,
}

/// Finds out which bodies fly, until a time \[s\].
pub(super) fn listed_flights(loaded: &LoadedScene, rows: &[ContactRow], duration: f64) -> ListedFlights {
    let world = &loaded.world;
    let rate = loaded.scene.simulation.pose_rate;
    let clock = PoseClock { rate: if rate > 0.0 { rate } else { DEFAULT_RATE }, duration };
    let mut bodies: Vec<Flown> = world.bodies.iter().map(|_| Flown::Unlisted).collect();
    for id in rows.iter().flat_map(|row| [row.body_a, row.body_b]) {
        let Some(body) = world.bodies.get(id.index()).filter(|body| matches!(body.motion, Motion::Free))
        else {
            continue;
        };
        let is_held =
            !body.supports.is_empty() || world.links.iter().any(|link| link.bodies().any(|end| end == id));
        bodies[id.index()] = if is_held { Flown::Held } else { Flown::Flies };
    }
    let flies = |id: BodyId| bodies[id.index()] == Flown::Flies;
    // Nothing is written yet, so nothing can fail.
    let disagreements = fly(world, rows, clock, &flies, &mut |_| Ok(())).unwrap_or_default();
    for (index, disagreement) in disagreements.iter().enumerate() {
        let size = world.bodies[index].surface.bounding_radius();
        if bodies[index] == Flown::Flies && disagreement.distance.0 > size {
            bodies[index] = Flown::Strays;
        }
    }
    let approaches = rows.iter().map(ContactRow::approach_speed).collect();
    ListedFlights { clock, bodies, disagreements, approaches }
}

impl ListedFlights {
    /// What should be known; `lines` are those of the rows in the list.
    pub(super) fn notices(&self, world: &World, lines: &[usize]) -> Vec<String> {
        let line = |place: usize| lines.get(place).copied().unwrap_or(0);
        let mut notices = Vec::new();
        for ((body, flown), found) in world.bodies.iter().zip(&self.bodies).zip(&self.disagreements) {
            let (name, (distance, farthest)) = (&body.name, found.distance);
            match flown {
                Flown::Unlisted => {}
                Flown::Held => notices.push(format!(
                    "{name} stays where the scene starts it: a link or a support holds it, of which \
                    a list of \
                     contacts tells nothing"
                )),
                Flown::Strays => notices.push(format!(
                    "{name} stays where the scene starts it: its flight under gravity and the \
                    listed impulses \
                     passes the contact of row {} at {distance:.4} m; start it where its first \
                     flight begins, \
                     list all of its contacts, or import poses",
                    line(farthest)
                )),
                Flown::Flies => {
                    if distance > surface_tolerance(body.surface.bounding_radius()) {
                        notices.push(format!(
                            "the flights of {name} miss the listed points by up to {distance:.4} m \
                            (row {}); it \
                             is put onto them",
                            line(farthest)
                        ));
                    }
                    let (speed, place) = found.approach;
                    let listed = self.approaches.get(place).copied().unwrap_or(0.0);
                    if listed > 0.0 && speed > listed {
                        notices.push(format!(
                            "{name} moves away from what it hits by its flight, or much faster than listed \
                             (row {}, {listed:.3} m/s): see whether the normal points from body_b to body_a",
                            line(place)
                        ));
                    } else if speed > APPROACH_TOLERANCE * listed {
                        notices.push(format!(
                            "the approach of {name} by its flights differs from that of the list by up to \
                             {speed:.3} m/s (row {}, {listed:.3} m/s); the list is taken",
                            line(place)
                        ));
                    }
                }
            }
        }
        notices
    }

    /// Writes the poses of the bodies that fly.
    ///
    /// # Errors
    /// Those of the writer.
    pub(super) fn write(
        &self,
        world: &World,
        rows: &[ContactRow],
        writer: &mut TimelineWriter,
    ) -> std::io::Result<()> {
        let flies = |id: BodyId| self.bodies[id.index()] == Flown::Flies;
        fly(world, rows, self.clock, &flies, &mut |row| writer.pose(row)).map(|_| ())
    }
}
