//! The device, on top of `wgpu`.

use std::ops::Range;
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

use super::{GpuError, NAME_VARIABLE};

/// Bytes of a word.
const WORD: u64 = 4;

/// An open graphics processor.
#[derive(Clone, Debug)]
pub struct Gpu {
    name: String,
    software: bool,
    device: wgpu::Device,
    queue: wgpu::Queue,
    limits: wgpu::Limits,
    /// The first error; commands report errors only when they run.
    failure: Arc<Mutex<Option<GpuError>>>,
}

/// Words in the memory of a device.
#[derive(Clone, Debug)]
pub struct GpuBuffer {
    buffer: wgpu::Buffer,
}

/// A compiled program of a device.
#[derive(Clone, Debug)]
pub struct GpuKernel {
    pipeline: wgpu::ComputePipeline,
}

/// A kernel, the buffers that it works on and the number of groups that run it.
#[derive(Clone, Debug)]
pub struct GpuTask {
    pipeline: wgpu::ComputePipeline,
    bindings: wgpu::BindGroup,
    groups: [u32; 3],
}

impl Gpu {
    /// Opens the fastest kind of device available: discrete, then integrated, then software. The environment
    /// variable [`NAME_VARIABLE`] selects by part of the name.
    ///
    /// # Errors
    /// [`GpuError::NoDevice`], [`GpuError::NoSuchDevice`], [`GpuError::Refused`].
    pub fn open() -> Result<Self, GpuError> {
        // Enumerate the adapters and apply the name filter.
        let wanted = std::env::var(NAME_VARIABLE).ok().filter(|name| !name.is_empty());
        let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL;
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let mut adapters = wait(instance.enumerate_adapters(backends));
        if adapters.is_empty() {
            return Err(GpuError::NoDevice);
        }
        if let Some(wanted) = wanted {
            let lower = wanted.to_lowercase();
            let found = adapters.iter().map(|a| a.get_info().name).collect::<Vec<_>>().join(", ");
            adapters.retain(|a| a.get_info().name.to_lowercase().contains(&lower));
            if adapters.is_empty() {
                return Err(GpuError::NoSuchDevice { wanted, found });
            }
        }
        // The first of the best kind; the system defines the order within a kind.
        let adapter =
            adapters.iter().min_by_key(|a| rank(a.get_info().device_type)).ok_or(GpuError::NoDevice)?;
        let info = adapter.get_info();
        let name = info.name;
        let limits = adapter.limits();
        // Open the device, and record its first asynchronous error.
        let (device, queue) = wait(adapter.request_device(&wgpu::DeviceDescriptor {
            required_limits: limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|e| GpuError::Refused { name: name.clone(), why: e.to_string() })?;

        let failure = Arc::new(Mutex::new(None));
        let note = {
            let (failure, name) = (Arc::clone(&failure), name.clone());
            move |error: wgpu::Error| {
                let name = name.clone();
                let error = match error {
                    wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory { name },
                    other => GpuError::Failed { name, why: other.to_string() },
                };
                failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            }
        };
        device.on_uncaptured_error(Arc::new(note));
        let software = info.device_type == wgpu::DeviceType::Cpu;
        Ok(Gpu { name, software, device, queue, limits, failure })
    }

    /// Name of the device, from the driver.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the device is software on this machine's processor.
    pub fn is_software(&self) -> bool {
        self.software
    }

    /// Most words that a buffer may have.
    pub fn most_words(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size) / WORD
    }

    /// A buffer of words; for a number of `f32`, its bits.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`].
    pub fn upload(&self, words: &[u32]) -> Result<GpuBuffer, GpuError> {
        let buffer = self.zeros(words.len())?;
        self.queue.write_buffer(&buffer.buffer, 0, bytemuck::cast_slice(words));
        self.check(buffer)
    }

    /// Replaces the first words of a buffer, before the next tasks.
    ///
    /// # Errors
    /// [`GpuError::Failed`] for more words than the buffer has.
    pub fn write(&self, buffer: &GpuBuffer, words: &[u32]) -> Result<(), GpuError> {
        self.queue.write_buffer(&buffer.buffer, 0, bytemuck::cast_slice(words));
        self.check(())
    }

    /// A buffer of zeros, of at least one word.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`].
    pub fn zeros(&self, words: usize) -> Result<GpuBuffer, GpuError> {
        let words = (words as u64).max(1);
        if words > self.most_words() {
            return Err(GpuError::TooLarge {
                name: self.name.clone(),
                bytes: words * WORD,
                most: self.most_words() * WORD,
            });
        }
        use wgpu::BufferUsages as Usage;
        let usage = Usage::STORAGE | Usage::UNIFORM | Usage::COPY_DST | Usage::COPY_SRC;
        self.check(GpuBuffer { buffer: self.new_buffer(words, usage) })
    }

    fn new_buffer(&self, words: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let size = words * WORD;
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Compiles a WGSL program with one entry point; all its bindings are in group 0.
    ///
    /// # Errors
    /// [`GpuError::Failed`] with the message of the compiler.
    pub fn kernel(&self, name: &str, wgsl: &str) -> Result<GpuKernel, GpuError> {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(wgsl.into()),
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        self.check(GpuKernel { pipeline })
    }

    /// Binds buffers to a kernel, in the order of its bindings 0, 1, …
    ///
    /// # Errors
    /// [`GpuError::Failed`].
    pub fn task(
        &self,
        kernel: &GpuKernel,
        buffers: &[&GpuBuffer],
        groups: [u32; 3],
    ) -> Result<GpuTask, GpuError> {
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.buffer.as_entire_binding() })
            .collect();
        let bindings = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &kernel.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        self.check(GpuTask { pipeline: kernel.pipeline.clone(), bindings, groups })
    }

    /// Submits tasks to the device without waiting. Each sees the writes of those before it.
    ///
    /// # Errors
    /// [`GpuError::Failed`], [`GpuError::OutOfMemory`].
    pub fn run<'a>(&self, tasks: impl IntoIterator<Item = &'a GpuTask>) -> Result<(), GpuError> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for task in tasks {
                let [x, y, z] = task.groups;
                pass.set_pipeline(&task.pipeline);
                pass.set_bind_group(0, &task.bindings, &[]);
                pass.dispatch_workgroups(x, y, z);
            }
        }
        self.queue.submit([encoder.finish()]);
        self.check(())
    }

    /// Waits for all tasks and copies numbers back.
    ///
    /// # Errors
    /// [`GpuError::Failed`], [`GpuError::OutOfMemory`].
    pub fn read(&self, buffer: &GpuBuffer, words: Range<usize>) -> Result<Vec<f32>, GpuError> {
        if words.is_empty() {
            return Ok(Vec::new());
        }
        let (start, length) = (words.start as u64 * WORD, words.len() as u64 * WORD);
        let staging =
            self.new_buffer(words.len() as u64, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&buffer.buffer, start, &staging, 0, length);
        self.queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |_| ());
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| self.failed(&e))?;
        self.check(())?;
        let view = staging.get_mapped_range(..).map_err(|e| self.failed(&e))?;
        Ok(bytemuck::pod_collect_to_vec(&view[..]))
    }

    fn failed(&self, why: &dyn std::error::Error) -> GpuError {
        GpuError::Failed { name: self.name.clone(), why: why.to_string() }
    }

    /// Returns a value unless an error has occurred.
    fn check<T>(&self, value: T) -> Result<T, GpuError> {
        match &*self.failure.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error.clone()),
            None => Ok(value),
        }
    }
}

/// Order of preference of the kinds of devices.
fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// The value of a future that is ready, as those of native drivers are.
fn wait<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        match future.as_mut().poll(&mut context) {
            Poll::Ready(value) => return value,
            Poll::Pending => std::thread::yield_now(),
        }
    }
}
