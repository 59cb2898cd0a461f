//! The last tallies of the process. A tally takes most of the time of a spectrum and depends on the grains only, not on
//! the thickness, density or light: where only these vary, it is computed once.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::tally::{Tally, TallyPart, TallyRequest};

/// Most tallies that are kept; one has some 0.3 MB with 16 streams and 3 MB with 128.
const MOST: usize = 16;

/// Tallies with what they were made from, the last used first.
static LAST: Mutex<VecDeque<(TallyRequest, Arc<Tally>)>> = Mutex::new(VecDeque::new());

/// What a request asks for, of a tally that is kept or new. It is the same whenever and from whichever tally it is
/// taken.
pub(super) fn tally(request: TallyRequest) -> TallyPart {
    if let Some(kept) = kept(&request) {
        return request.part_of(kept);
    }
    // Nothing is locked while rays are traced: a thread that waits for rays may start another tally meanwhile.
    let tally = Arc::new(request.tally());
    let part = request.part_of(Arc::clone(&tally));
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    last.push_front((request, tally));
    last.truncate(MOST);
    part
}

fn kept(request: &TallyRequest) -> Option<Arc<Tally>> {
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let place = last.iter().position(|(made, _)| made.covers(request))?;
    let found = last.remove(place)?;
    let tally = Arc::clone(&found.1);
    last.push_front(found);
    Some(tally)
}

#[cfg(test)]
mod tests {
    use super::super::population::Population;
    use super::super::tally::TallyPlan;
    use super::*;
    use crate::sample::SnowSample;

    fn request(degree: usize, most_absorption: f64, seed: u64) -> TallyRequest {
        let plan = TallyPlan { degree, rays: 64, seed };
        TallyRequest::new(&Population::of_sample(&SnowSample::default()), 1.30..=1.31, most_absorption, &plan)
    }

    #[test]
    fn requests_within_a_tally_share_it_and_others_do_not() {
        // Other tests of this process may use the cache in between, but not sixteen others at once.
        let first = tally(request(4, 0.1, 7));
        let shares = |other: TallyRequest| first.is_of_the_tally_of(&tally(other));
        assert!(shares(request(4, 0.1, 7)) && shares(request(3, 0.1, 7)) && shares(request(4, 0.001, 7)));
        assert!(!shares(request(4, 0.1, 8)) && !shares(request(5, 0.1, 7)) && !shares(request(4, 10.0, 7)));
    }

    /// To the last bit and on any number of threads, so that a snow has the same spectrum alone and among others.
    #[test]
    fn a_part_of_a_wider_tally_is_the_tally_of_a_narrower_request() {
        let sample = SnowSample::default();
        let tally_on = |threads: usize, request: &TallyRequest| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            Arc::new(pool.install(|| request.tally()))
        };
        let narrow = request(4, 0.1, 9);
        let own = narrow.part_of(tally_on(1, &narrow));
        let wide = request(12, 30.0, 9);
        let shared = narrow.part_of(tally_on(3, &wide));
        let narrowed = wide.part_of(tally_on(2, &wide)).narrowed(4, 0.1);
        // From weak absorption to the end of the narrower grid, x = 0.1, where the interpolation has no later values.
        for absorption_per_m in [0.01, 3.0, 100.0, 220.0] {
            for without in [None, Some(3)] {
                let of = |part: &TallyPart| part.scattering(&sample.grain_size, 1.304, absorption_per_m, without);
                assert_eq!(of(&own), of(&shared));
                assert_eq!(of(&own), of(&narrowed));
            }
        }
    }
}
