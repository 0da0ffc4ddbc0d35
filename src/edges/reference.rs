//! Reference implementations for tests: the definitions, pixel by pixel, as plain formulas, without regard to speed.
//!
//! In and out as in `canny` and `blur`. Invariants: shares no code with them. Must not know: how they work.

use std::collections::BTreeSet;

/// `cv2.Canny` with an aperture of 3 and the L1 norm. Thresholds are whole numbers, the low one first.
pub fn canny(pixels: &[u8], width: usize, low: i64, high: i64) -> Vec<[u32; 2]> {
    let (width, height) = (width as i64, (pixels.len() / width) as i64);
    let pixel = |x: i64, y: i64| i64::from(pixels[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize]);
    let gradient = |x: i64, y: i64| {
        let (mut dx, mut dy) = (0, 0);
        for along in -1..=1_i64 {
            let weight = 2 - along.abs();
            dx += weight * (pixel(x + 1, y + along) - pixel(x - 1, y + along));
            dy += weight * (pixel(x + along, y + 1) - pixel(x + along, y - 1));
        }
        (dx, dy)
    };
    let is_inside = |x: i64, y: i64| (0..width).contains(&x) && (0..height).contains(&y);
    let size = |x: i64, y: i64| {
        let (dx, dy) = gradient(x, y);
        if is_inside(x, y) { dx.abs() + dy.abs() } else { 0 }
    };
    let is_ridge = |x: i64, y: i64| {
        let ((dx, dy), here) = (gradient(x, y), size(x, y));
        let (run, rise) = (dx.abs() * 13_573, dy.abs() * 32_768);
        if rise < run {
            here > size(x - 1, y) && here >= size(x + 1, y)
        } else if rise > run + dx.abs() * 65_536 {
            here > size(x, y - 1) && here >= size(x, y + 1)
        } else {
            let side = if dx.signum() * dy.signum() < 0 { -1 } else { 1 };
            here > size(x - side, y - 1) && here > size(x + side, y + 1)
        }
    };
    let all = || (0..height).flat_map(|y| (0..width).map(move |x| (y, x)));
    let weak: BTreeSet<(i64, i64)> = all().filter(|&(y, x)| size(x, y) > low && is_ridge(x, y)).collect();
    let mut edges: BTreeSet<(i64, i64)> = weak.iter().copied().filter(|&(y, x)| size(x, y) > high).collect();
    loop {
        let is_near = |&(y, x): &(i64, i64)| (-1..=1).any(|v| (-1..=1).any(|u| edges.contains(&(y + v, x + u))));
        let more: Vec<_> = weak.difference(&edges).copied().filter(is_near).collect();
        if more.is_empty() {
            return edges.into_iter().map(|(y, x)| [x as u32, y as u32]).collect();
        }
        edges.extend(more);
    }
}

/// A blur by a kernel of weights that add up to 256, along rows and columns.
pub fn blur(pixels: &[u8], width: usize, kernel: &[u16]) -> Vec<u8> {
    let (width, height) = (width as i64, (pixels.len() / width) as i64);
    let reach = kernel.len() as i64 / 2;
    // Mirrors a position at the first and the last pixel, which are not repeated.
    let mirror = |at: i64, length: i64| {
        let turn = at.rem_euclid((2 * (length - 1)).max(1));
        turn.min((2 * (length - 1) - turn).max(0))
    };
    let shade = |x: i64, y: i64| {
        let mut total = 0;
        for (v, &down) in (-reach..).zip(kernel) {
            for (u, &right) in (-reach..).zip(kernel) {
                let pixel = pixels[(mirror(y + v, height) * width + mirror(x + u, width)) as usize];
                total += u64::from(down) * u64::from(right) * u64::from(pixel);
            }
        }
        ((total + 32_768) >> 16) as u8
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| shade(x, y)).collect()
}
