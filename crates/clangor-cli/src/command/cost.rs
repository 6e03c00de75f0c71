//! What a scene will cost, estimated before anything is spent: text, bodies, triangles, pairs, steps, rows,
//! modes, and the CPU time of models by the estimator that bakes use. `check --cost` and `inspect` show it.

use std::collections::BTreeSet;
use std::sync::Arc;

use clangor_core::body::Surface;
use clangor_pipeline::stages::bake_costs::{BakeCost, Estimate, bake_costs};
use clangor_pipeline::stages::body_facts::{AUDIBLE, BodyFacts};
use clangor_pipeline::stages::load::LoadedScene;
use clangor_pipeline::stages::simulate::solver;
use clangor_pipeline::stages::sound_models::Quality;
use clangor_pipeline::stages::sound_models::patience::cpu_time;
use clangor_sim::Solver;
use serde_json::{Value, json};

use crate::console::Console;

/// Fewer modes than this are not counted by their density.
pub(super) const FEW: f64 = 10.0;

/// Unknowns of a solve that no solver takes: the number says nothing.
const BEYOND: f64 = 1e5;

/// The amounts that a scene asks for.
pub(crate) struct SceneCost {
    text_bytes: usize,
    bodies: usize,
    forms: usize,
    triangles: usize,
    /// Pairs of bodies of which one moves.
    pairs: u64,
    /// Steps of the time-stepped solver; `None` for the exact one, which has none.
    steps: Option<u64>,
    /// Poses of the timeline, without those at impacts.
    pose_rows: u64,
    /// Estimated modes up to 20 kHz of all forms but planes.
    modes: f64,
    /// Of the models of all forms, at each quality; of unknowns the most of any form.
    models: Vec<BakeCost>,
}

impl SceneCost {
    /// The cost of a scene; nothing is simulated or baked.
    pub(crate) fn of(loaded: &LoadedScene) -> Self {
        let (world, simulation) = (&loaded.world, &loaded.scene.simulation);
        let mut forms = BTreeSet::new();
        let (mut triangles, mut modes, mut models) = (0, 0.0, Vec::<BakeCost>::new());
        for body in &world.bodies {
            if !forms.insert((Arc::as_ptr(&body.surface).addr(), body.material.name.as_str())) {
                continue;
            }
            if let Surface::Mesh(surface) = &*body.surface {
                triangles += surface.mesh.triangles.len();
            }
            let mut costs = bake_costs(&body.surface, Some(&body.material), Estimate::Quick);
            // What is held rings and does not click.
            if !body.motion.is_movable() {
                costs.iter_mut().for_each(|cost| (cost.clicks, cost.unknowns) = (0.0, 0.0));
            }
            add(&mut models, &costs);
            if !body.surface.is_plane() {
                modes += BodyFacts::of(&body.surface)
                    .map_or(0.0, |facts| facts.modes_below(AUDIBLE, &body.material).0);
            }
        }
        let count = world.bodies.len() as u64;
        let moving = world.bodies.iter().filter(|body| body.motion.is_movable()).count() as u64;
        let steps = (simulation.duration / simulation.time_step).ceil() as u64;
        SceneCost {
            text_bytes: loaded.text.len(),
            bodies: world.bodies.len(),
            forms: forms.len(),
            triangles,
            pairs: moving * (count - moving) + moving * moving.saturating_sub(1) / 2,
            steps: (solver(loaded) == Solver::Rigid).then_some(steps),
            pose_rows: (moving as f64 * simulation.duration * simulation.pose_rate).ceil() as u64,
            modes,
            models,
        }
    }

    /// Prints it.
    pub(crate) fn say(&self, console: &Console) {
        let SceneCost { text_bytes, bodies, forms, triangles, pairs, steps, pose_rows, modes, models } = self;
        console.say(format_args!(
            "  {text_bytes} bytes of text, {bodies} bodies of {forms} forms, {triangles} triangles, \
             {pairs} pairs that may meet"
        ));
        let steps = steps.map_or("no steps (exact solver)".into(), |steps| format!("{steps} steps"));
        console.say(format_args!("  {steps}, {pose_rows} rows of poses besides those of impacts"));
        match *modes < FEW {
            true => console.say(format_args!(
                "  few modes to 20 kHz: fewer than {FEW} by their density, which counts bars too low"
            )),
            false => console.say(format_args!("  about {modes:.0} modes to 20 kHz by their density")),
        }
        say_costs(models, console);
    }

    /// For other programs.
    pub(crate) fn json(&self) -> Value {
        json!({
            "text_bytes": self.text_bytes,
            "bodies": self.bodies,
            "forms": self.forms,
            "triangles": self.triangles,
            "pairs": self.pairs,
            "steps": self.steps,
            "pose_rows": self.pose_rows,
            "estimated_modes_to_20_khz": self.modes,
            "bake_costs": self.models.iter().map(cost_json).collect::<Vec<_>>(),
        })
    }
}

/// Adds the costs of a form to those of others, quality by quality.
fn add(all: &mut Vec<BakeCost>, costs: &[BakeCost]) {
    if all.is_empty() {
        all.extend_from_slice(costs);
        return;
    }
    for (sum, cost) in all.iter_mut().zip(costs) {
        sum.clicks += cost.clicks;
        sum.unknowns = sum.unknowns.max(cost.unknowns);
        sum.ringing = sum.ringing.zip(cost.ringing).map(|(one, two)| one + two);
    }
}

/// One line with the estimated CPU time of the models at each quality.
pub(super) fn say_costs(costs: &[BakeCost], console: &Console) {
    if costs.is_empty() {
        return;
    }
    let part = |cost: &BakeCost| {
        let clicks = cpu_time(cost.clicks);
        let ringing = cost.ringing.map_or(String::new(), |seconds| format!(" + {}", cpu_time(seconds)));
        format!("{} {clicks}{ringing}", quality_name(cost.quality))
    };
    let all: Vec<String> = costs.iter().map(part).collect();
    let parts = if costs[0].ringing.is_some() { "clicks + ringing" } else { "clicks" };
    console.say(format_args!("  a bake takes about ({parts}, CPU time): {}", all.join(", ")));
    let of_normal = costs.iter().find(|cost| cost.quality == Quality::Normal && cost.unknowns > 0.0);
    if let Some(cost) = of_normal {
        if cost.unknowns < BEYOND {
            console
                .say(format_args!("  a solve for clicks has about {:.0} unknowns (normal)", cost.unknowns));
        } else {
            console.say(format_args!("  an exact solve for clicks is out of reach (normal)"));
        }
    }
}

fn quality_name(quality: Quality) -> &'static str {
    match quality {
        Quality::Draft => "draft",
        Quality::Normal => "normal",
        Quality::High => "high",
    }
}

pub(super) fn cost_json(cost: &BakeCost) -> Value {
    json!({
        "quality": quality_name(cost.quality),
        "clicks_s": cost.clicks,
        "unknowns": cost.unknowns,
        "ringing_s": cost.ringing,
    })
}
