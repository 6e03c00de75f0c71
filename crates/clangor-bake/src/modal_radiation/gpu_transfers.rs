//! Transfers of many modes at many places on a graphics processor (\[FRAC\] §4), equal to
//! `ModalTransfer::undelayed`.
//!
//! ```text
//! harmonics: Y of every place ─┐
//! waves: θₙ ratios of every place and mode ─┴─► sums: Σ_n waves Σ_m c Y of every place and mode ─► read
//! ```
//!
//! The coefficients stay on the device. A call sends directions and distances and returns one complex number
//! for each mode and place. All arithmetic is `f32`: products of the ratios of up to 60 orders are accurate
//! to 1e-5.

use clangor_core::sound_model::modal::model::ModalTransfer;
use glam::DVec3;
use num_complex::Complex64;

use crate::gpu::{Gpu, GpuBuffer, GpuError, GpuKernel, GpuTask};

/// Words of a mode's head: first coefficient, first wave, order, bits of κ.
const HEAD: usize = 4;
/// Invocations of a group, one for each coefficient in turn.
const GROUP: usize = 64;

/// The transfers of a body on a device.
pub struct GpuTransfers {
    gpu: Gpu,
    order: usize,
    modes: usize,
    waves: usize,
    heads: GpuBuffer,
    coefficients: GpuBuffer,
    kernels: [GpuKernel; 3],
    /// Buffers and tasks for as many places as the last call had.
    prepared: Option<Prepared>,
}

struct Prepared {
    places: usize,
    where_to: GpuBuffer,
    sums: GpuBuffer,
    tasks: [GpuTask; 3],
}

impl GpuTransfers {
    /// Uploads transfers with their wavenumbers κ = kR to the device.
    ///
    /// # Errors
    /// [`GpuError`].
    pub fn new(gpu: &Gpu, transfers: &[(&ModalTransfer, f64)]) -> Result<Self, GpuError> {
        let (mut heads, mut coefficients, mut waves) = (Vec::new(), Vec::new(), 0);
        for (transfer, wavenumber) in transfers {
            let first = coefficients.len() / 2;
            heads.extend([first as u32, waves as u32, transfer.order as u32, bits(*wavenumber)]);
            coefficients.extend(transfer.coefficients.iter().flat_map(|c| [bits(c.re), bits(c.im)]));
            waves += transfer.order + 1;
        }
        let kernel = |name, source: &str| {
            gpu.kernel(
                name,
                &format!("const GROUP = {GROUP}u;\n{}{source}", include_str!("gpu_transfers/mode.wgsl")),
            )
        };
        Ok(GpuTransfers {
            order: transfers.iter().map(|(t, _)| t.order).max().unwrap_or_default(),
            modes: heads.len() / HEAD,
            waves,
            heads: gpu.upload(&heads)?,
            coefficients: gpu.upload(&coefficients)?,
            kernels: [
                kernel("harmonics", include_str!("gpu_transfers/harmonics.wgsl"))?,
                kernel("waves", include_str!("gpu_transfers/waves.wgsl"))?,
                kernel("sums", include_str!("gpu_transfers/sums.wgsl"))?,
            ],
            gpu: gpu.clone(),
            prepared: None,
        })
    }

    /// p e^{s|x|}/(ρ R) [kg^−½] of every mode at every place, in units of R: modes in the inner order.
    ///
    /// # Errors
    /// [`GpuError`].
    pub fn evaluate(&mut self, places: &[DVec3]) -> Result<Vec<Complex64>, GpuError> {
        if places.is_empty() || self.modes == 0 {
            return Ok(Vec::new());
        }
        let prepared = match self.prepared.take() {
            Some(prepared) if prepared.places == places.len() => prepared,
            _ => self.prepare(places.len())?,
        };
        let words: Vec<u32> = places
            .iter()
            .flat_map(|x| {
                let distance = x.length();
                let DVec3 { x, y, z } = *x / distance;
                [x, y, z, distance].map(bits)
            })
            .collect();
        self.gpu.write(&prepared.where_to, &words)?;
        self.gpu.run(&prepared.tasks)?;
        let sums = self.gpu.read(&prepared.sums, 0..2 * self.modes * places.len())?;
        self.prepared = Some(prepared);
        Ok(sums.chunks_exact(2).map(|c| Complex64::new(f64::from(c[0]), f64::from(c[1]))).collect())
    }

    /// Buffers and tasks for this many places.
    fn prepare(&self, places: usize) -> Result<Prepared, GpuError> {
        let gpu = &self.gpu;
        let sizes = [self.modes, places, self.order, self.waves].map(|n| n as u32);
        let sizes = gpu.upload(&sizes)?;
        let where_to = gpu.zeros(4 * places)?;
        let harmonics = gpu.zeros(places * (self.order + 1) * (self.order + 1))?;
        let waves = gpu.zeros(2 * places * self.waves)?;
        let sums = gpu.zeros(2 * places * self.modes)?;
        let [of_harmonics, of_waves, of_sums] = &self.kernels;
        let groups = |n: usize| n.div_ceil(GROUP) as u32;
        let tasks = [
            gpu.task(
                of_harmonics,
                &[&sizes, &where_to, &harmonics],
                [groups(self.order + 1), places as u32, 1],
            )?,
            gpu.task(
                of_waves,
                &[&sizes, &self.heads, &where_to, &waves],
                [groups(self.modes), places as u32, 1],
            )?,
            gpu.task(
                of_sums,
                &[&sizes, &self.heads, &self.coefficients, &harmonics, &waves, &sums],
                [self.modes as u32, places as u32, 1],
            )?,
        ];
        Ok(Prepared { places, where_to, sums, tasks })
    }
}

fn bits(x: f64) -> u32 {
    (x as f32).to_bits()
}
