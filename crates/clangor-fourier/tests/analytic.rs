//! A transform whose result is known. Not in the module: its own tests would compile the library again.

use clangor_fourier::Planner;

#[test]
fn a_cosine_is_one_amplitude_and_comes_back() {
    let (length, harmonic) = (12, 3);
    let angle = |l: usize| std::f64::consts::TAU * (harmonic * l) as f64 / length as f64;
    let signal: Vec<f64> = (0..length).map(|l| angle(l).cos()).collect();
    let mut planner = Planner::new();
    let (forward, inverse) = (planner.forward(length), planner.inverse(length));
    let (mut spectrum, mut back) = (forward.make_output_vec(), inverse.make_output_vec());
    forward.process(&mut signal.clone(), &mut spectrum).unwrap();
    for (m, amplitude) in spectrum.iter().enumerate() {
        let expected = if m == harmonic { length as f64 / 2.0 } else { 0.0 };
        // Seen: 2.4e-15.
        assert!((amplitude.re - expected).hypot(amplitude.im) < 1e-14, "{m}: {amplitude}");
    }
    inverse.process(&mut spectrum, &mut back).unwrap();
    for (x, y) in signal.iter().zip(back) {
        // Seen: 2.2e-16.
        assert!((x - y / length as f64).abs() < 1e-15, "{x} {y}");
    }
}
