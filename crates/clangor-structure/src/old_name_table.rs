//! Lists the names that have been replaced by the field's words, and the files that may still hold them.
//!
//! To edit: one line per name. `*` stands for any run of characters; the third column restricts the line to
//! files whose path contains the text.

use crate::old_names::NameKind::{self, Constant, Function, Identifier, Module, Type};
use crate::old_names::OldName;

/// Files with aliases of old names, which keep working for one version.
pub const ALIAS_FILES: &[&str] = &[];

const fn old(
    kind: NameKind,
    pattern: &'static str,
    within: &'static str,
    replacement: &'static str,
) -> OldName {
    OldName { kind, pattern, within, replacement }
}

/// The old names.
pub const OLD_NAMES: &[OldName] = &[
    // Bodies of revolution.
    old(Module, "turned*", "", "axisymmetric*"),
    old(Module, "round", "", "axisymmetric"),
    old(Module, "revolution", "", "axisymmetric"),
    old(Type, "Turned*", "", "Axisymmetric*"),
    old(Type, "Revolution*", "", "Axisymmetric*"),
    old(Type, "Round*Solver", "", "Axisymmetric*Solver"),
    old(Module, "meridian_fit", "", "detect_axisymmetry"),
    old(Module, "octant", "", "symmetric_patches"),
    old(Type, "Octant*", "", "SymmetricPatches*"),
    // Modes.
    old(Module, "vibration", "clangor-bake/src", "modal_analysis"),
    old(Module, "modes", "clangor-bake/src", "eigensolver, or fdtd/modal_bursts"),
    old(Type, "Vibration*", "", "ModalAnalysis*"),
    // Finite differences in time, and radiation of modes.
    old(Module, "wave", "clangor-bake/src", "fdtd"),
    old(Module, "waves", "clangor-bake/src/modal_radiation", "fdtd_transfer"),
    old(Module, "triangles", "clangor-bake/src/modal_radiation", "bem_transfer"),
    // Finite elements.
    old(Type, "FilledBody", "", "VolumeFem"),
    old(Type, "Divisible", "", "RefinableDiscretization"),
    old(Module, "stuffing", "", "isosurface_stuffing"),
    old(Module, "surface_loads", "", "contact_tractions, or normal_velocity_projection"),
    old(Type, "SurfaceLoads", "", "ContactTractions, or NormalVelocityProjection"),
    // Degrees of freedom; the constants of that name elsewhere are degrees of polynomials.
    old(Constant, "DEGREES", "crates/clangor/src", "RIGID_DOFS"),
    old(Constant, "DEGREES", "crates/clangor-core/src", "RIGID_DOFS"),
    // Impacts.
    old(Type, "Blow", "", "ImpactEvent, ContactLoad, or ImpulsePair"),
    old(Type, "Blows", "", "ImpactEvents"),
    old(Module, "blows", "", "impacts"),
    old(Type, "Struck", "", "ImpactTarget"),
    old(Type, "Click", "", "AccelerationPulse"),
    old(Type, "Course", "", "by content: ForceSamples, …"),
    // Propagation.
    old(Module, "ways", "", "propagation paths"),
    old(Module, "live_ways", "", "propagation paths"),
    old(Module, "heard_wave", "", "received_wave"),
    old(Type, "LiveWays", "", "PropagationPaths"),
    old(Type, "Hearing", "", "PathRenderer"),
    old(Type, "HeardWave", "", "ReceivedWave"),
    // Sound of modes.
    old(Module, "ringers", "", "modal_sources"),
    old(Type, "Ringer*", "", "ModalSource*"),
    old(Type, "RingingPlan", "", "ModalPlan"),
    old(Type, "ModalBank", "synthesis", "ResonatorBank"),
    old(Module, "modal_bank*", "", "modal_soundbank*"),
    // Evaluators, and the papers' representations.
    old(Module, "playable_*", "", "*_evaluator"),
    old(Type, "Playable*", "", "*Evaluator"),
    old(Module, "published*", "", "pan_representation"),
    old(Type, "Published*", "", "Pan*"),
    // State of modes that pieces inherit.
    old(Module, "handover", "", "modal_state_transfer"),
    old(Type, "Handover", "", "ModalStateTransfer"),
    old(Function, "push_ringing", "", "inherit_state"),
    // Live playing.
    old(Module, "live_score", "", "event_schedule"),
    old(Type, "LiveScore", "", "EventSchedule"),
    old(Function, "rehearse", "", "measure_peak"),
    old(Module, "feed", "", "event_feeder"),
    old(Type, "Feed", "", "EventFeeder"),
    old(Type, "Seat", "", "ObjectSlot"),
    old(Type, "Leaving", "", "RetiringObject"),
    // Conventions of Rust.
    old(Function, "possible", "", "clamped"),
    old(Function, "of_scene", "", "from_scene"),
    old(Function, "is_sane", "", "is_within_limits"),
    // Progress and reports.
    old(Identifier, "told", "", "on_progress"),
    old(Type, "Told", "", "RenderReportView"),
    // Data for other programs, for the page, and for the audio thread.
    old(Module, "exchange", "", "interchange, or wasm_buffer"),
    old(Type, "Exchange*", "", "Interchange*, or EngineChannels"),
];
