//! Arithmetic on a graphics processor: one device, buffers of 32-bit words, and kernels that run over them.
//!
//! ```text
//! Gpu::open ─► upload, zeros ─► kernel (WGSL) ─► task: a kernel, its buffers, how many groups ─► run ─► read
//! ```
//!
//! It needs the feature `gpu`; only [`GpuError`] is there without. Vulkan is what is tested; on a Mac it is
//! Metal that is compiled in. Nothing here draws or needs a window. A software device will do (Mesa's
//! llvmpipe): it is slower than this library's own code on the same processor, and computes the same numbers.
//!
//! WGSL has no 64-bit floating point, and lets a device fuse a product and a sum: results agree with those of
//! the processor to the rounding of `f32`, not bit by bit.

#[cfg(feature = "gpu")]
mod device;

#[cfg(feature = "gpu")]
pub use device::{Gpu, GpuBuffer, GpuKernel, GpuTask};

/// Name of the environment variable that holds part of the name of the device to take.
pub const NAME_VARIABLE: &str = "WGPU_ADAPTER_NAME";

/// Why a graphics processor cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// The feature `gpu` is off.
    #[error(
        "this build cannot use graphics processors; one made with `cargo build --release --features gpu` can"
    )]
    NotBuilt,
    /// No device, not even one in software.
    #[error(
        "there is no Vulkan device: install the driver of your graphics processor, or one in software \
         (Debian, Ubuntu: `apt-get install mesa-vulkan-drivers`)"
    )]
    NoDevice,
    /// No device has the name given in the environment.
    #[error("no device is called \"{wanted}\" ({NAME_VARIABLE}); there are: {found}")]
    NoSuchDevice {
        /// Requested part of the name.
        wanted: String,
        /// Names of those that there are.
        found: String,
    },
    /// A device cannot be opened.
    #[error("the device \"{name}\" cannot be opened: {why}")]
    Refused {
        /// Name of the device.
        name: String,
        /// What its driver says.
        why: String,
    },
    /// A buffer larger than the device binds.
    #[error("a buffer of {bytes} bytes is needed, and \"{name}\" binds at most {most}")]
    TooLarge {
        /// Name of the device.
        name: String,
        /// Bytes needed.
        bytes: u64,
        /// Most that it binds.
        most: u64,
    },
    /// The device's memory is full.
    #[error("the memory of \"{name}\" is full")]
    OutOfMemory {
        /// Name of the device.
        name: String,
    },
    /// The device is lost, or has rejected a command.
    #[error("\"{name}\" failed: {why}")]
    Failed {
        /// Name of the device.
        name: String,
        /// What its driver says.
        why: String,
    },
}
