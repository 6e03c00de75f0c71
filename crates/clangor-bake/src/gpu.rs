//! Arithmetic on a graphics processor: one device, buffers of 32-bit words, and kernels that run over them.
//!
//! ```text
//! Gpu::open ─► upload, zeros ─► kernel (WGSL) ─► task: a kernel, its buffers, how many groups ─► run ─► read
//! ```
//!
//! Requires the feature `gpu`; without it only [`GpuError`] exists. Tested with Vulkan; on a Mac, Metal is
//! compiled in. Nothing here draws or needs a window. A software device works (Mesa's llvmpipe): it is slower
//! than this library's code on the same processor, and computes the same numbers.
//!
//! WGSL has no 64-bit floating point, and lets a device fuse a product and a sum: results agree with those of
//! the processor to the rounding of `f32`, not bit by bit.

#[cfg(feature = "gpu")]
mod device;

#[cfg(feature = "gpu")]
pub use device::{Gpu, GpuBuffer, GpuKernel, GpuTask};

/// Environment variable that selects a device by part of its name.
pub const NAME_VARIABLE: &str = "WGPU_ADAPTER_NAME";

/// Reasons why a graphics processor cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// The feature `gpu` is off.
    #[error(
        "this build cannot use graphics processors; one made with `cargo build --release --features gpu` can"
    )]
    NotBuilt,
    /// No device, not even a software one.
    #[error(
        "there is no Vulkan device: install the driver of your graphics processor, or one in software \
         (Debian, Ubuntu: `apt-get install mesa-vulkan-drivers`)"
    )]
    NoDevice,
    /// No device matches the name in the environment variable.
    #[error("no device is called \"{wanted}\" ({NAME_VARIABLE}); there are: {found}")]
    NoSuchDevice {
        /// Requested part of the name.
        wanted: String,
        /// Names of the available devices.
        found: String,
    },
    /// A device cannot be opened.
    #[error("the device \"{name}\" cannot be opened: {why}")]
    Refused {
        /// Name of the device.
        name: String,
        /// Message of the driver.
        why: String,
    },
    /// A buffer larger than the device binds.
    #[error("a buffer of {bytes} bytes is needed, and \"{name}\" binds at most {most}")]
    TooLarge {
        /// Name of the device.
        name: String,
        /// Bytes needed.
        bytes: u64,
        /// Largest buffer that it binds.
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
        /// Message of the driver.
        why: String,
    },
}
