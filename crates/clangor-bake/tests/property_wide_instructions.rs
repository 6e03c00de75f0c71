//! The time steps of the wave equation are compiled for wide vectors: the machine code of this program
//! itself is searched for them.
//!
//! The code for AVX-512 and for AVX2 is in the program whatever processor runs it, and needs no symbols to be
//! found: nothing else that this program links subtracts many packed 32-bit numbers close together.

#![cfg(all(target_arch = "x86_64", target_os = "linux"))]

use std::ops::ControlFlow;

use clangor_bake::fdtd::{Boundary, WaveOptions, WaveSolver};
use clangor_core::shape::Shape;

/// Bytes within which the instructions of the stencil lie.
const NEAR: usize = 1024;

/// Opcode of the subtraction of packed 32-bit numbers.
const SUBTRACTION: u8 = 0x5c;

/// Whether bytes are the subtraction in 512-bit registers, without mask.
fn is_evex_512(code: &[u8]) -> bool {
    // Prefix 62, map 0F; 32-bit numbers, no mandatory prefix; length 512, no mask.
    let [prefix, map, form, length, opcode, ..] = code else { return false };
    let prefixed = *prefix == 0x62 && map & 0x0f == 1 && form & 0x87 == 4;
    prefixed && length & 0xe7 == 0x40 && *opcode == SUBTRACTION
}

/// The same in 256-bit registers, by either prefix of AVX.
fn is_vex_256(code: &[u8]) -> bool {
    match code {
        [0xc5, form, opcode, ..] => form & 0x07 == 4 && *opcode == SUBTRACTION,
        [0xc4, map, form, opcode, ..] => map & 0x1f == 1 && form & 0x87 == 4 && *opcode == SUBTRACTION,
        _ => false,
    }
}

/// Most of such instructions within [`NEAR`] bytes.
fn densest(program: &[u8], is: fn(&[u8]) -> bool) -> usize {
    let found: Vec<usize> = (0..program.len()).filter(|at| is(&program[*at..])).collect();
    let within = |first: usize| found[first..].iter().take_while(|at| **at < found[first] + NEAR).count();
    (0..found.len()).map(within).max().unwrap_or(0)
}

#[test]
fn the_stencil_is_compiled_for_wide_vectors() {
    // The solver is in the program only if it runs.
    let options = WaveOptions {
        max_wavenumber: 1.0,
        spacing: 0.5,
        order: 1,
        boundary: Boundary::CutCells,
        longest: 0.5,
    };
    let solver = WaveSolver::try_new(&Shape::parse("sphere:1").unwrap().mesh(), options).unwrap();
    solver.run(&|_| ControlFlow::Continue(())).unwrap();
    let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
    let (evex, vex) = (densest(&program, is_evex_512), densest(&program, is_vex_256));
    println!("{evex} with 512 bits, {vex} with 256 bits");
    // Seen: 20 and 22; none where the sweep is a closure, which is compiled for 128 bits.
    assert!(evex > 5, "{evex} subtractions of 512 bits");
    assert!(vex > 5, "{vex} subtractions of 256 bits");
}
