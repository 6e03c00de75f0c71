//! A room against its statistics: decay time, and level during the decay.

use std::f64::consts::{LN_10, PI, TAU};

use clangor_core::glam::DVec3;
use clangor_core::medium::Medium;
use clangor_core::propagation::{
    Air, LateReverberation, OCTAVES, ReverberationTimes, Room, RoomError, WallAbsorption,
};

const RATE: f64 = 48_000.0;

/// 4 × 2.7 × 6 m: plaster, a carpet, windows.
fn room() -> Room {
    let plaster = WallAbsorption([0.2, 0.15, 0.1, 0.08, 0.08, 0.1, 0.12]);
    let carpet = WallAbsorption([0.08, 0.15, 0.3, 0.4, 0.5, 0.6, 0.6]);
    let glass = WallAbsorption([0.35, 0.25, 0.18, 0.12, 0.07, 0.04, 0.04]);
    Room {
        lowest: DVec3::ZERO,
        highest: DVec3::new(4.0, 2.7, 6.0),
        walls: [plaster, plaster, carpet, plaster, plaster, glass],
        image_order: 1,
        late: true,
    }
}

/// Mean square of the sound of a pulse of 1 Pa m of energy in each input in turn.
fn response(input: usize, seconds: f64) -> Vec<f64> {
    let (room, air) = (room(), Air::default());
    let mut network =
        LateReverberation::new(&room, Some(&air), Medium::AIR.sound_speed, RATE).expect("a room");
    let mut inputs = [0.0; LateReverberation::INPUTS];
    inputs[input] = 1.0;
    (0..(seconds * RATE) as usize)
        .map(|_| {
            let mut output = [0.0];
            network.step(&inputs, &mut output);
            inputs[input] = 0.0;
            output[0]
        })
        .collect()
}

/// Only an octave around `middle`.
fn octave(sound: &[f64], middle: f64) -> Vec<f64> {
    // A resonance divided by its peak, three times.
    let (sin, cos) = (TAU * middle / RATE).sin_cos();
    let alpha = sin / (2.0 * 1.4);
    let a0 = 1.0 + alpha;
    let mut sound = sound.to_vec();
    for _ in 0..3 {
        let (mut x1, mut x2, mut y1, mut y2) = (0.0, 0.0, 0.0, 0.0);
        for s in &mut sound {
            let y = (alpha * (*s - x2) + 2.0 * cos * y1 - (1.0 - alpha) * y2) / a0;
            (x2, x1, y2, y1, *s) = (x1, *s, y1, y, y);
        }
    }
    sound
}

/// Twice the time in which the remaining energy falls from −5 to −35 dB \[s\].
fn decay_time(to_come: &[f64]) -> f64 {
    let reaches = |decibels: f64| {
        let limit = to_come[0] * 10.0_f64.powf(0.1 * decibels);
        to_come.partition_point(|e| *e > limit) as f64 / RATE
    };
    2.0 * (reaches(-35.0) - reaches(-5.0))
}

/// Energy from each sample on.
fn still_to_come(sound: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut to_come: Vec<f64> = sound
        .iter()
        .rev()
        .map(|p| {
            sum += p * p;
            sum
        })
        .collect();
    to_come.reverse();
    to_come
}

#[test]
fn the_room_decays_as_its_walls_and_air_say() {
    let (room, air) = (room(), Air::default());
    let times = ReverberationTimes::new(&room, Some(&air), Medium::AIR.sound_speed);
    let sounds: Vec<Vec<f64>> = (0..LateReverberation::INPUTS).map(|input| response(input, 3.0)).collect();
    let pulse = [&[1.0][..], &vec![0.0; 1 << 14]].concat();
    for middle in OCTAVES {
        // An octave holds sounds of different decay: each of its frequencies, as loud as the octave lets it.
        let filter = octave(&pulse, middle);
        let parts: Vec<(f64, f64)> = (-40..=40)
            .map(|k| middle * 2.0_f64.powf(f64::from(k) / 20.0))
            .map(|f| {
                let (mut re, mut im) = (0.0, 0.0);
                for (n, h) in filter.iter().enumerate() {
                    let angle = TAU * f * n as f64 / RATE;
                    (re, im) = (re + h * angle.cos(), im - h * angle.sin());
                }
                (6.0 * LN_10 / times.at(f), f * (re * re + im * im))
            })
            .collect();
        let expected: Vec<f64> = (0..sounds[0].len())
            .step_by(16)
            .map(|n| parts.iter().map(|(decay, e)| e / decay * (-decay * n as f64 / RATE).exp()).sum())
            .collect();
        let wanted = 16.0 * decay_time(&expected);
        // One response is noise, whose energy is not smooth.
        let mut to_come = vec![0.0; sounds[0].len()];
        for sound in &sounds {
            to_come.iter_mut().zip(still_to_come(&octave(sound, middle))).for_each(|(e, more)| *e += more);
        }
        let seen = decay_time(&to_come);
        println!("{middle} Hz: {seen:.3} s for {wanted:.3} s, {:.3} s in the middle", times.at(middle));
        assert!((seen / wanted - 1.0).abs() < 0.05, "{middle} Hz: {seen} s for {wanted} s");
    }
}

#[test]
fn the_room_is_as_loud_as_statistics_say() {
    let (room, air) = (room(), Air::default());
    let times = ReverberationTimes::new(&room, Some(&air), Medium::AIR.sound_speed);
    let inputs = LateReverberation::INPUTS;
    // Six directions that each take a sixth of the energy.
    let sounds: Vec<Vec<f64>> = (0..inputs).map(|input| response(input, 3.0)).collect();
    for middle in [250.0, 1000.0, 4000.0] {
        let pulse = octave(&[&[1.0][..], &vec![0.0; 20_000]].concat(), middle);
        let sent: f64 = pulse.iter().map(|p| p * p).sum();
        let heard: f64 = sounds.iter().flat_map(|s| octave(s, middle)).map(|p| p * p).sum();
        let speed = Medium::AIR.sound_speed;
        let decay = 6.0 * LN_10 / times.at(middle);
        let wanted = 4.0 * PI * speed / room.volume() / decay;
        let decibels = 10.0 * (heard / sent / wanted).log10();
        println!("{middle} Hz: {decibels:.2} dB");
        // The first 13 ms belong to the images; they would be 1.3 to 1.9 dB of it.
        assert!((-2.0..0.0).contains(&decibels), "{middle} Hz: {decibels} dB");
    }
}

#[test]
fn rooms_without_absorption_are_rejected() {
    let hard = Room { walls: [WallAbsorption::even(0.0); 6], ..room() };
    let refused = LateReverberation::new(&hard, None, Medium::AIR.sound_speed, RATE).map(|_| ());
    assert_eq!(refused, Err(RoomError::Undamped { octave: 125.0 }));
    let flat = Room { highest: DVec3::new(4.0, 0.0, 6.0), ..room() };
    assert!(matches!(
        LateReverberation::new(&flat, None, 343.0, RATE).map(|_| ()),
        Err(RoomError::Empty { .. })
    ));
}
