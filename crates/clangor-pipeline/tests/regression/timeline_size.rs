//! A raw log stays small and comes back in full: the bench `timeline` at a size that a test can afford.

use clangor_core::timeline::TimelineSink;
use clangor_pipeline::formats::timeline_file::{TimelineReader, TimelineWriter};

use crate::pile::{Pile, header};

#[test]
fn raw_log_takes_at_most_16_bytes_a_row() {
    // More than one row group.
    let rows = 300_000;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pile.timeline");
    let mut writer = TimelineWriter::create(&path, &header(), false).unwrap();
    let mut source = Pile::new(3);
    let mut impulse = 0.0;
    for _ in 0..rows {
        let row = source.next_row();
        impulse += row.impulse_n;
        writer.contact(&row).unwrap();
    }
    assert_eq!(writer.finish().unwrap().contacts, rows);
    let bytes = std::fs::metadata(path.join("contacts.parquet")).unwrap().len();
    // Seen: 14.17.
    assert!(bytes <= 16 * rows, "{:.2} bytes a row", bytes as f64 / rows as f64);

    let mut read = 0;
    let mut read_impulse = 0.0;
    let mut source = Pile::new(3);
    for row in TimelineReader::open(&path).unwrap().contacts().unwrap() {
        let (row, written) = (row.unwrap(), source.next_row());
        assert_eq!((row.time, row.body_a, row.body_b), (written.time, written.body_a, written.body_b));
        read += 1;
        read_impulse += row.impulse_n;
    }
    assert_eq!(read, rows);
    // Rounding is unbiased: seen -3.4e-8, where a single row is off by up to 3e-5.
    assert!((read_impulse / impulse - 1.0).abs() < 1e-6, "{:e}", read_impulse / impulse - 1.0);
}
