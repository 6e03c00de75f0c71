//! A whole run: steps, log, and replacement of the bodies that break.

use std::ops::ControlFlow;

use clangor_core::body::{Body, BodyId, Life, World};
use clangor_core::contact::modal_energy::ModesOf;
use clangor_core::timeline::{ContactKind, ContactRow, FractureRow};

use super::compliance::ContactModes;
use super::replacement::{Breaker, CrackImpulse, Replacement};
use super::step_log::{PairImpulses, StepLog};
use super::world::RigidWorld;
use crate::record::Recorder;
use crate::{ContactModel, SimulationError, SimulationSettings};

/// Steps between two calls of the progress report.
const PROGRESS_CHECK: u64 = 64;

/// Simulates a world whose bodies have these modes; after each step a `breaker` returns the bodies that
/// break.
pub(crate) fn run(
    world: &World,
    (settings, modes): (&SimulationSettings, ModesOf<'_>),
    recorder: &mut Recorder<'_>,
    mut breaker: Option<Breaker<'_>>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(), SimulationError> {
    if !(settings.duration >= 0.0 && settings.duration.is_finite()) {
        return Err(SimulationError::BadSetting { setting: "duration", value: settings.duration });
    }
    let mut rigid = RigidWorld::try_new(world, settings.time_step, settings.sleep)?;
    let mut log = if recorder.ignores_slow_contacts() {
        StepLog::without_slow_contacts(recorder.settings().v_min)
    } else {
        StepLog::new()
    };
    let followed = breaker.is_some();
    let modes = Some(ContactModes { modes, v_min: recorder.settings().v_min, followed })
        .filter(|_| settings.contact == ContactModel::Compliant);
    let interval = recorder.pose_interval();
    let bodies = (0..world.bodies.len() as u32).map(BodyId);
    for body in bodies.clone() {
        recorder.pose(&rigid.pose(body))?;
    }
    let mut moving: Vec<BodyId> = bodies.filter(|b| rigid.bodies[b.index()].can_move()).collect();
    let mut next_pose = 1_u64;
    let steps = (settings.duration / settings.time_step - 1e-9).ceil() as u64;
    for k in 0..steps {
        rigid.step_with(&mut log, modes)?;
        let broken = breaker.as_mut().map_or(Ok(Vec::new()), |breaker| breaker(&mut rigid, &mut log))?;
        for PairImpulses { kind, rows, poses, .. } in log.groups() {
            match kind {
                ContactKind::Impact => recorder.impact(rows, poses)?,
                _ => recorder.contact(rows, poses)?,
            }
        }
        recorder.advance(rigid.time())?;
        // Half a step of tolerance keeps the rate if interval and step are commensurable.
        let pictured = rigid.time() + 0.5 * settings.time_step >= next_pose as f64 * interval;
        if pictured {
            for &body in &moving {
                recorder.pose(&rigid.pose(body))?;
            }
            next_pose = (rigid.time() / interval + 0.5).floor() as u64 + 1;
        }
        for replacement in broken {
            let parent = replacement.row.parent;
            if !pictured && rigid.is_alive(parent) {
                recorder.pose(&rigid.pose(parent))?;
            }
            let pieces = break_up(&mut rigid, replacement, recorder)?;
            for &piece in &pieces {
                recorder.pose(&rigid.pose(piece))?;
            }
            moving.retain(|body| *body != parent);
            moving.extend(pieces);
        }
        if k % PROGRESS_CHECK == 0 && progress(rigid.time()).is_break() {
            return Err(SimulationError::Interrupted);
        }
    }
    recorder.count_solves(rigid.solved_impacts());
    Ok(())
}

/// Replaces a body by its pieces and records the fracture.
fn break_up(
    rigid: &mut RigidWorld,
    replacement: Replacement,
    recorder: &mut Recorder<'_>,
) -> Result<Vec<BodyId>, SimulationError> {
    let Replacement { row, mut pieces, cracks } = replacement;
    let time = rigid.time();
    let ids = rigid.replace(row.parent, &pieces)?;
    pieces.iter_mut().for_each(|piece: &mut Body| piece.life = Life::of_piece(row.parent, time));
    let row = FractureRow { time, first_child: ids[0], children: ids.len() as u32, ..row };
    let mut rows = Vec::new();
    for crack in &cracks {
        let Some((a, b)) = ids.get(crack.piece_a).zip(ids.get(crack.piece_b)) else {
            let (body, reason) = (rigid.names[row.parent.index()].clone(), "has a crack beside no piece");
            return Err(SimulationError::CannotBreak { body, reason, time });
        };
        rows.push(crack_row(crack, time, (*a, *b)));
    }
    recorder.fracture(&row, &pieces, rows)?;
    Ok(ids)
}

fn crack_row(crack: &CrackImpulse, time: f64, (body_a, body_b): (BodyId, BodyId)) -> ContactRow {
    let impulse_n = crack.impulse.dot(crack.normal);
    ContactRow {
        time,
        body_a,
        body_b,
        kind: ContactKind::Fracture,
        point: crack.point,
        normal: crack.normal,
        impulse_n,
        impulse_t: crack.impulse - crack.normal * impulse_n,
        couple: crack.couple,
        velocity: glam::DVec3::ZERO,
        depth: 0.0,
        impact_id: 0,
        effective_mass: None,
    }
}
