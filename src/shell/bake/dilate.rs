//! Texels beside islands: filters that look there find what the island has, and none of it is changed.

/// Rings of texels that are filled: those of a bilinear filter, and of two coarser levels.
const RINGS: usize = 4;

/// Fills texels of label 0 around the others with the mean of their neighbours that have a value; rows of `width`.
pub fn dilate(picture: &mut [[f32; 3]], labels: &[u16], width: usize) {
    let mut known: Vec<bool> = labels.iter().map(|label| *label != 0).collect();
    for _ in 0..RINGS {
        let ring: Vec<(usize, [f32; 3])> = (0..picture.len())
            .filter(|i| !known[*i])
            .filter_map(|i| Some((i, mean(picture, &known, width, i)?)))
            .collect();
        for (i, value) in ring {
            (picture[i], known[i]) = (value, true);
        }
    }
}

/// The mean of the neighbours of texel `i` that are known, if any is.
fn mean(picture: &[[f32; 3]], known: &[bool], width: usize, i: usize) -> Option<[f32; 3]> {
    let (x, y, height) = (i % width, i / width, picture.len() / width);
    let near = |at: usize, most: usize| at.saturating_sub(1)..(at + 2).min(most);
    let around = near(y, height).flat_map(|y| near(x, width).map(move |x| y * width + x));
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for i in around.filter(|i| known[*i]) {
        sum = [0, 1, 2].map(|c| sum[c] + picture[i][c]);
        count += 1.0;
    }
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn islands_keep_their_texels_and_get_a_border() {
        let (width, labels) = (16, (0..256).map(|i| u16::from(i == 8 * 16 + 8)).collect::<Vec<_>>());
        let mut picture = vec![[0.0; 3]; 256];
        picture[8 * 16 + 8] = [1.0, 2.0, 3.0];
        dilate(&mut picture, &labels, width);
        for (i, value) in picture.iter().enumerate() {
            let far = (i % 16).abs_diff(8).max((i / 16).abs_diff(8));
            assert_eq!(*value, if far <= RINGS { [1.0, 2.0, 3.0] } else { [0.0; 3] }, "{i}");
        }
    }

    #[test]
    fn two_islands_do_not_write_into_each_other() {
        let labels = [1, 0, 2];
        let mut picture = [[1.0; 3], [0.0; 3], [3.0; 3]];
        dilate(&mut picture, &labels, 3);
        assert_eq!(picture, [[1.0; 3], [2.0; 3], [3.0; 3]]);
    }
}
