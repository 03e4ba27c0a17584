//! The example runs, and cuts at the right positions.

#[path = "../../examples/saw_in_your_loop.rs"]
mod saw_in_your_loop;

#[test]
fn every_piece_is_as_long_as_the_other() {
    let cuts = saw_in_your_loop::run(20.0).expect("a station");
    assert!(cuts.len() >= 9, "{}", cuts.len());
    for (number, cut) in (1..).zip(&cuts) {
        let expected = 1_000.0 * f64::from(number);
        assert!((cut.place - expected).abs() < 1e-6, "{}", cut.place);
        assert!(cut.slip.abs() < 1e-6, "{}", cut.slip);
    }
}
