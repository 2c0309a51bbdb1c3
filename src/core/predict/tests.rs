use super::*;

fn belief(variance: f32, freedom: f32) -> Belief {
    Belief { variance, light: 1.0, freedom }
}

#[test]
fn wild_positions_carry_nothing() {
    let before = [1, 2, 3, 4, 5, 6];
    let wild =
        [[f32::NAN, 0.5], [0.5, f32::INFINITY], [-0.1, 0.5], [3.0, 0.5], [2.9999998, 1.9999999], [0.0, 0.0]];
    let mut out = [0; 6];
    carry(&before, 3, 2, &wild, -1, &mut out).unwrap();
    assert_eq!(out, [-1, -1, -1, -1, 6, 1]);
    assert_eq!(carry(&before, 3, 3, &wild, -1, &mut out), Err(Error::Size));
}

#[test]
fn knowledge_adds_up_and_saturates() {
    let filter = Filter::new(100.0);
    let mut beliefs = [belief(1.0, 20.0); 64];
    let mut last = 20.0;
    for _ in 0..50 {
        filter.update(8, &mut beliefs, &[belief(1.0, 20.0); 64]).unwrap();
        assert!(beliefs[0].freedom >= last);
        last = beliefs[0].freedom;
    }
    // In equilibrium f = 1/(1/f + drift/spread) + 20.
    assert!(last > 40.0 && last < filter.spread / filter.drift + 20.0, "{last}");
    assert!((beliefs[5].variance - 1.0).abs() < 1e-5);
}

#[test]
fn a_change_of_everything_is_followed() {
    let filter = Filter::new(100.0);
    let mut beliefs = [belief(1.0, 1000.0); 64];
    let outlook = filter.update(8, &mut beliefs, &[belief(100.0, 100.0); 64]).unwrap();
    assert!(beliefs.iter().all(|b| b.variance > 85.0), "{:?}", beliefs[0]);
    assert!(outlook.surprise > 0.9 && outlook.known == 1.0);
}

#[test]
fn a_single_bright_sample_is_not() {
    let filter = Filter::new(100.0);
    let mut beliefs = [belief(1.0, 400.0); 256];
    let mut seen = [belief(1.0, 20.0); 256];
    seen[77].variance = 1000.0;
    filter.update(16, &mut beliefs, &seen).unwrap();
    assert!(beliefs[77].variance < 150.0, "{:?}", beliefs[77]);
}

#[test]
fn what_is_not_a_number_is_forgotten() {
    let filter = Filter::new(100.0);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
        let spoilt = Belief { variance: bad, light: 1.0, freedom: 5.0 };
        let mut beliefs = [spoilt; 8];
        filter.update(8, &mut beliefs, &[belief(2.0, 3.0); 8]).unwrap();
        assert_eq!(beliefs, [belief(2.0, 3.0); 8]);
        let outlook = filter.update(8, &mut beliefs, &[spoilt; 8]).unwrap();
        assert!(beliefs.iter().all(|b| b.variance == 2.0) && outlook.surprise == 0.0);
    }
    assert_eq!(filter.update(3, &mut [Belief::NONE; 8], &[Belief::NONE; 8]), Err(Error::Size));
}
