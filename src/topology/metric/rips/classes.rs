//! Homology classes of cycles over Z/2, as sums of births.
//!
//! In: births in order, sums that become zero.
//! Out: which birth dies with each of these (the elder rule: the youngest of the sum).
//! Invariants: what a dead birth has become is a sum of elder ones. A settled sum names births that are alive. Sums are
//! rewritten only when they are used, and then kept.
//! Must not know: edges, lunes.

/// A sum of births as bits, one a birth.
pub type Total = Vec<u64>;

/// A sum as it is stored: few births in a list, or many as bits.
#[derive(Clone, Debug)]
enum Sum {
    Few(Vec<u32>),
    Many(Vec<u64>),
}

impl Sum {
    fn of(total: &[u64]) -> Self {
        let used = total.len() - total.iter().rev().take_while(|&&bits| bits == 0).count();
        let count = total.iter().map(|bits| bits.count_ones()).sum::<u32>() as usize;
        if count > used { Self::Many(total[..used].to_vec()) } else { Self::Few(births(total).collect()) }
    }

    fn add_to(&self, total: &mut [u64]) {
        match self {
            Self::Few(few) => few.iter().for_each(|&birth| toggle(total, birth)),
            Self::Many(many) => total.iter_mut().zip(many).for_each(|(total, bits)| *total ^= bits),
        }
    }

    fn meets(&self, set: &[u64]) -> bool {
        match self {
            Self::Few(few) => few.iter().any(|&birth| set[birth as usize / 64] >> (birth % 64) & 1 != 0),
            Self::Many(many) => many.iter().zip(set).any(|(bits, set)| bits & set != 0),
        }
    }
}

/// What a birth has become.
#[derive(Clone, Debug)]
struct Dead {
    sum: Sum,
    /// The number of its death.
    number: u32,
    /// How many deaths there were when it was last rewritten.
    as_of: u32,
    /// What it was when the birth died, if it was rewritten since and is remembered.
    first: Option<Sum>,
}

/// All classes of a sweep.
#[derive(Clone, Debug, Default)]
pub struct Classes {
    /// One entry a birth; none while it is alive.
    fates: Vec<Option<Box<Dead>>>,
    dead: Vec<u64>,
    deaths: u32,
    work: Total,
    /// Whether it is remembered what births became when they died.
    remembers: bool,
}

impl Classes {
    /// No classes yet. Those that [`settle_as_of`](Self::settle_as_of) is asked for remember what births became.
    pub fn new(remembers: bool) -> Self {
        Self { remembers, ..Self::default() }
    }

    /// The number of births that are alive.
    pub fn alive(&self) -> usize {
        self.fates.len() - self.deaths as usize
    }

    /// A new class is born.
    pub fn bear(&mut self) {
        if self.fates.len().is_multiple_of(64) {
            self.dead.push(0);
        }
        self.fates.push(None);
    }

    /// The zero sum.
    pub fn zero(&self) -> Total {
        vec![0; self.dead.len()]
    }

    /// Rewrites a sum in terms of those alive: from the youngest down, since the dead are sums of elder ones.
    pub fn settle(&mut self, total: &mut [u64]) {
        while let Some(birth) = youngest(total, &self.dead) {
            toggle(total, birth);
            self.refresh(birth);
            if let Some(fate) = &self.fates[birth as usize] {
                fate.sum.add_to(total);
            }
        }
    }

    /// Rewrites what a dead birth has become.
    fn refresh(&mut self, birth: u32) {
        let Some(fate) = &self.fates[birth as usize] else { return };
        if fate.as_of == self.deaths {
            return;
        }
        let rewritten = fate.sum.meets(&self.dead).then(|| {
            let mut work = std::mem::take(&mut self.work);
            work.clear();
            work.resize(self.dead.len(), 0);
            fate.sum.add_to(&mut work);
            while let Some(birth) = youngest(&work, &self.dead) {
                toggle(&mut work, birth);
                if let Some(fate) = &self.fates[birth as usize] {
                    fate.sum.add_to(&mut work);
                }
            }
            let sum = Sum::of(&work);
            self.work = work;
            sum
        });
        if let Some(fate) = &mut self.fates[birth as usize] {
            fate.as_of = self.deaths;
            if let Some(sum) = rewritten {
                let before = std::mem::replace(&mut fate.sum, sum);
                if self.remembers {
                    fate.first.get_or_insert(before);
                }
            }
        }
    }

    /// Rewrites a sum in terms of the births that were alive when those were dead for which `is_dead` holds: the first
    /// ones to die, up to some death. The classes must remember.
    pub fn settle_as_of(&self, is_dead: impl Fn(u32) -> bool, total: &mut [u64]) {
        debug_assert!(self.remembers, "what births became is not remembered");
        // What a birth became is a sum of elder ones, so one pass from the youngest down meets them all.
        for birth in (0..self.fates.len() as u32).rev() {
            let is_in = total[birth as usize / 64] >> (birth % 64) & 1 != 0;
            if let Some(fate) = self.fates[birth as usize].as_ref().filter(|_| is_in && is_dead(birth)) {
                toggle(total, birth);
                fate.first.as_ref().unwrap_or(&fate.sum).add_to(total);
            }
        }
    }

    /// Splits a sum of births that were alive at one time into classes that die each by itself: of each its birth,
    /// the eldest first. The class that dies with a birth is the sum of it and of what it became. The classes must
    /// remember.
    pub fn split_by_death(&self, total: &mut [u64]) -> Vec<u32> {
        debug_assert!(self.remembers, "what births became is not remembered");
        let mut found = Vec::new();
        loop {
            let dead = births(total).filter_map(|birth| Some((birth, self.fates[birth as usize].as_deref()?)));
            let Some((birth, fate)) = dead.min_by_key(|(_, fate)| fate.number) else { break };
            found.push(birth);
            toggle(total, birth);
            fate.first.as_ref().unwrap_or(&fate.sum).add_to(total);
        }
        found.extend(births(total));
        found.sort_unstable();
        found
    }

    /// Makes a settled sum zero. Returns the birth that dies of it: its youngest; none if it is zero already.
    pub fn kill(&mut self, total: &mut [u64]) -> Option<u32> {
        let word = total.iter().rposition(|&bits| bits != 0)?;
        let birth = word as u32 * 64 + total[word].ilog2();
        toggle(total, birth);
        self.deaths += 1;
        self.fates[birth as usize] =
            Some(Box::new(Dead { sum: Sum::of(total), number: self.deaths, as_of: self.deaths, first: None }));
        self.dead[word] |= 1 << (birth % 64);
        Some(birth)
    }
}

/// Adds a birth to a sum.
#[inline]
pub fn toggle(total: &mut [u64], birth: u32) {
    total[birth as usize / 64] ^= 1 << (birth % 64);
}

/// The births of a sum, the eldest first.
pub fn births(total: &[u64]) -> impl Iterator<Item = u32> + '_ {
    total.iter().enumerate().flat_map(|(word, &bits)| {
        let set = (0..64).filter(move |bit| bits >> bit & 1 != 0);
        set.map(move |bit| word as u32 * 64 + bit)
    })
}

/// The last element of two sets.
fn youngest(total: &[u64], set: &[u64]) -> Option<u32> {
    let word = (0..total.len()).rev().find(|&word| total[word] & set[word] != 0)?;
    Some(word as u32 * 64 + (total[word] & set[word]).ilog2())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(classes: &Classes, births: &[u32]) -> Total {
        let mut total = classes.zero();
        births.iter().for_each(|&birth| toggle(&mut total, birth));
        total
    }

    #[test]
    fn the_youngest_of_a_sum_dies_and_becomes_the_others() {
        let mut classes = Classes::default();
        (0..130).for_each(|_| classes.bear());
        assert_eq!(classes.kill(&mut sum(&classes, &[3, 70, 129])), Some(129));
        let mut total = sum(&classes, &[129, 128]);
        classes.settle(&mut total);
        assert_eq!(births(&total).collect::<Vec<_>>(), [3, 70, 128]);
        // 70 becomes 3: so what 129 has become is zero.
        assert_eq!(classes.kill(&mut sum(&classes, &[3, 70])), Some(70));
        let mut total = sum(&classes, &[129]);
        classes.settle(&mut total);
        assert_eq!(births(&total).count(), 0);
        assert_eq!(classes.kill(&mut total), None);
        assert_eq!(classes.alive(), 128);
    }

    #[test]
    fn what_a_birth_became_is_remembered() {
        let mut classes = Classes::new(true);
        (0..130).for_each(|_| classes.bear());
        classes.kill(&mut sum(&classes, &[3, 70, 129]));
        classes.kill(&mut sum(&classes, &[3, 70]));
        let mut now = sum(&classes, &[129]);
        classes.settle(&mut now);
        assert_eq!(births(&now).count(), 0);
        let as_of = |dead: &[u32]| {
            let mut total = sum(&classes, &[129, 5]);
            classes.settle_as_of(|birth| dead.contains(&birth), &mut total);
            births(&total).collect::<Vec<_>>()
        };
        assert_eq!(as_of(&[]), [5, 129]);
        assert_eq!(as_of(&[129]), [3, 5, 70]);
        assert_eq!(as_of(&[129, 70]), [5]);
    }

    #[test]
    fn a_sum_is_split_into_classes_that_die_by_themselves() {
        let mut classes = Classes::new(true);
        (0..130).for_each(|_| classes.bear());
        classes.kill(&mut sum(&classes, &[3, 70, 129]));
        classes.kill(&mut sum(&classes, &[3, 70]));
        let split = |births: &[u32]| classes.split_by_death(&mut sum(&classes, births));
        // 3 + 70 + 129 dies with 129, and 3 + 70 with 70. 3 and 5 live on.
        assert_eq!(split(&[3, 70, 129]), [129]);
        assert_eq!(split(&[129]), [70, 129]);
        assert_eq!(split(&[70, 5]), [3, 5, 70]);
        assert_eq!(split(&[]), []);
    }

    #[test]
    fn long_sums_are_rewritten_like_short_ones() {
        let mut classes = Classes::default();
        (0..300).for_each(|_| classes.bear());
        let most: Vec<u32> = (0..250).collect();
        let mut long = sum(&classes, &[&most[..], &[299]].concat());
        assert_eq!(classes.kill(&mut long), Some(299));
        assert_eq!(classes.kill(&mut sum(&classes, &[10, 249])), Some(249));
        let mut total = sum(&classes, &[299]);
        classes.settle(&mut total);
        let expected: Vec<u32> = (0..249).filter(|&birth| birth != 10).collect();
        assert_eq!(births(&total).collect::<Vec<_>>(), expected);
    }
}
