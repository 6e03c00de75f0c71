//! \[FRAC\] Figs. 4 and 5: the less a crack costs, the higher its pieces sound; what the impulses of cracks
//! add to the onset.

use clangor_core::scene::render_description::Parts;

use crate::broken_tile::{Tile, median, onset_energy};

#[test]
#[ignore = "a minute: cargo test --release -p clangor-pipeline --test paper fracture_sound:: -- --ignored"]
fn lower_toughness_gives_more_and_higher_pieces() {
    let medians = |toughness: f64| {
        let fallen: Vec<_> =
            (0..10).map(|seed| Tile { toughness, crack_impulses: true, seed }.fall()).collect();
        let count = median(fallen.iter().map(|tile| tile.pieces().count() as f64).collect());
        let pitch = median(fallen.iter().map(|tile| median(tile.pitches())).collect());
        println!("{toughness} J/m²: {count} pieces, of {:.2} kHz in the middle", 1e-3 * pitch);
        (count, pitch)
    };
    let found = [80.0, 120.0, 200.0].map(medians);
    for pair in found.windows(2) {
        assert!(pair[0].0 > pair[1].0 && pair[0].1 > pair[1].1, "{found:?}");
    }
}

/// What cracks add to the first 5 ms of the ringing, and of clicks and ringing together \[dB\].
fn rise(seed: u64) -> [f64; 2] {
    let energies = [false, true].map(|crack_impulses| {
        let fallen = Tile { toughness: 150.0, crack_impulses, seed }.fall();
        let models = fallen.models();
        [false, true].map(|acceleration| {
            let parts = Parts { acceleration, modal: true, ground: false };
            onset_energy(&fallen.heard(&models, parts), 5.0)
        })
    });
    [0, 1].map(|part| 10.0 * (energies[1][part] / energies[0][part]).log10())
}

/// Every tile breaks alike at first, and then otherwise, as its pieces fly otherwise: only the median says
/// something.
///
/// As in \[FRAC\] Fig. 5 the impulses of cracks make the onset louder: the force of the impact ends when the
/// body falls apart, so that it no longer gives the modes as much as the cracks do.
#[test]
#[ignore = "a minute: cargo test --release -p clangor-pipeline --test paper fracture_sound:: -- --ignored"]
fn crack_impulses_make_the_onset_louder() {
    let rises: Vec<[f64; 2]> = (0..10).map(rise).collect();
    let [ringing, whole] = [0, 1].map(|part| rises.iter().map(|rise| rise[part]).collect::<Vec<f64>>());
    println!("ringing {ringing:.2?} dB, median {:.2} dB", median(ringing.clone()));
    println!("clicks and ringing {whole:.2?} dB, median {:.2} dB", median(whole.clone()));
    // Seen: medians 1.91 and 1.74 dB, single tiles from −5 to 8 dB.
    for rises in [&ringing, &whole] {
        assert!((0.5..4.0).contains(&median(rises.clone())), "{ringing:?} {whole:?}");
    }
}
