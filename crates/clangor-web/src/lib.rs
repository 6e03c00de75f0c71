//! The real-time engine as a WebAssembly module with a plain C interface, without glue code.
//!
//! The page instantiates the module three times: [`synth`] in an `AudioWorklet`, [`world`] in a worker, and
//! [`strike`] on the main thread. The instances share nothing. All numbers are SI. Pointers are byte offsets
//! into the memory of the instance; a call that allocates may move it, so the page renews its views after
//! each call. The exported functions have the names of the functions in the modules, which document them and
//! which native code can call.
//!
//! The page writes text, files and lists of f64 into [`wasm_buffer::buffer`]. Functions that return an `i32`
//! return a negative number on failure, and [`wasm_buffer::message`] says why.
//!
//! [`layout`] describes the rows of numbers.

pub mod layout;
pub mod strike;
pub mod synth;
pub mod wasm_buffer;
pub mod world;

/// Exports functions of the modules under their own names.
///
/// An exported name is a promise to the linker that no other function has it, which is why the attribute is
/// called unsafe. The code behind it is not.
macro_rules! export {
    ($($module:ident::$name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        mod exports {
            use super::{strike, synth, wasm_buffer, world};

            $(
                #[doc = concat!(
                    "[`", stringify!($name), "`](super::", stringify!($module), "::", stringify!($name), ")."
                )]
                #[allow(unsafe_code, reason = "the attribute, not what is called")]
                #[unsafe(no_mangle)]
                extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                    $module::$name($($argument),*)
                }
            )*
        }
    };
}

export! {
    wasm_buffer::buffer(bytes: u32) -> *const u64;
    wasm_buffer::message() -> *const u8;
    wasm_buffer::message_length() -> u32;
    synth::synth_start(sample_rate: f64, block: u32, scene_bytes: u32) -> i32;
    synth::synth_load(slot: u32, bytes: u32, damping_bytes: u32) -> i32;
    synth::synth_listener(lx: f64, ly: f64, lz: f64, rx: f64, ry: f64, rz: f64) -> i32;
    synth::synth_push(count: u32) -> u32;
    synth::synth_gain(pascal_at_full_scale: f64) -> i32;
    synth::synth_acceleration(on: u32) -> i32;
    synth::synth_modal(on: u32) -> i32;
    synth::synth_reflections(on: u32) -> i32;
    synth::synth_silence() -> i32;
    synth::synth_render(frames: u32) -> *const f32;
    synth::synth_latency() -> f64;
    synth::synth_time() -> f64;
    synth::synth_report() -> *const f64;
    strike::strike_load(slot: u32, bytes: u32) -> i32;
    strike::strike_materials() -> i32;
    strike::strike_impact(slot: u32, material: u32) -> i32;
    strike::strike_events() -> *const f64;
    strike::strike_contact() -> *const f64;
    world::world_load(scene_bytes: u32) -> i32;
    world::world_advance(until: f64, budget_s_hint: f64) -> i32;
    world::world_time() -> f64;
    world::world_body_count() -> u32;
    world::world_bodies() -> *const f64;
    world::world_link_count() -> u32;
    world::world_links() -> *const f64;
    world::world_materials() -> i32;
    world::world_poses() -> *const f32;
    world::world_velocities() -> *const f32;
    world::world_events_count() -> u32;
    world::world_events() -> *const f64;
    world::world_contacts_count() -> u32;
    world::world_contacts() -> *const f64;
    world::world_clear();
    world::world_set_velocity(body: u32, x: f64, y: f64, z: f64) -> i32;
    world::world_add_sphere(material: u32) -> i32;
    world::world_remove(body: u32) -> i32;
    world::world_gravity(x: f64, y: f64, z: f64) -> i32;
    world::world_energy() -> f64;
    world::world_solver() -> u32;
}
