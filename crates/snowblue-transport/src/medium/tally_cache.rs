//! The last tallies of the process. A tally takes most of the time of a spectrum and depends on the grains only, not on
//! the thickness, density or light: where only these vary, it is computed once.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::tally::{Tally, TallyRequest};

/// Most tallies that are kept; one has some 0.3 MB with 16 streams and 3 MB with 128.
const MOST: usize = 16;

/// Tallies with what they were made from, the last used first.
static LAST: Mutex<VecDeque<(TallyRequest, Arc<Tally>)>> = Mutex::new(VecDeque::new());

/// The tally of a request, kept or new. A tally is the same whenever it is made.
pub(super) fn tally(request: TallyRequest) -> Arc<Tally> {
    if let Some(kept) = kept(&request) {
        return kept;
    }
    // Nothing is locked while rays are traced: a thread that waits for rays may start another tally meanwhile.
    let tally = Arc::new(request.tally());
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    last.push_front((request, Arc::clone(&tally)));
    last.truncate(MOST);
    tally
}

fn kept(request: &TallyRequest) -> Option<Arc<Tally>> {
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let place = last.iter().position(|(made, _)| made == request)?;
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

    #[test]
    fn equal_requests_share_a_tally_and_others_do_not() {
        let request = |seed: u64| {
            let plan = TallyPlan { degree: 4, rays: 64, seed };
            TallyRequest::new(&Population::of_sample(&SnowSample::default()), 1.30..=1.31, 0.1, &plan)
        };
        // Other tests of this process may use the cache in between, but not sixteen others at once.
        let first = tally(request(7));
        assert!(Arc::ptr_eq(&first, &tally(request(7))));
        assert!(!Arc::ptr_eq(&first, &tally(request(8))));
        let differs = |size: f64| {
            let plan = TallyPlan { degree: 4, rays: 64, seed: 7 };
            TallyRequest::new(&Population::of_sample(&SnowSample::default()), 1.30..=1.31, size, &plan) != request(7)
        };
        // The grid of absorptions has four nodes in each decade.
        assert!(differs(10.0) && !differs(0.099));
    }
}
