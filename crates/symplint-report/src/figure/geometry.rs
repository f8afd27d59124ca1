//! Points and rectangles on the page, in page units with y pointing down.

/// A place on the page.
pub(super) type Point = (f64, f64);

/// An upright rectangle on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// The four corners, in order around the rectangle.
    pub fn corners(&self) -> [Point; 4] {
        [
            (self.left, self.top),
            (self.right, self.top),
            (self.right, self.bottom),
            (self.left, self.bottom),
        ]
    }

    /// The rectangle with every side moved outwards by `by`.
    pub fn grown(&self, by: f64) -> Rect {
        Rect {
            left: self.left - by,
            top: self.top - by,
            right: self.right + by,
            bottom: self.bottom + by,
        }
    }

    pub fn contains(&self, (x, y): Point) -> bool {
        x >= self.left && x <= self.right && y >= self.top && y <= self.bottom
    }

    /// The part of the segment from `a` to `b` inside, by Liang and Barsky's clipping.
    pub fn clip(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (slope, room) in [
            (-dx, a.0 - self.left),
            (dx, self.right - a.0),
            (-dy, a.1 - self.top),
            (dy, self.bottom - a.1),
        ] {
            if slope == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if slope < 0.0 {
                enter = enter.max(room / slope);
            } else {
                leave = leave.min(room / slope);
            }
        }
        let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
        // The untouched ends are kept bit for bit: the caller compares them to join segments.
        (enter <= leave).then(|| {
            (
                if enter == 0.0 { a } else { at(enter) },
                if leave == 1.0 { b } else { at(leave) },
            )
        })
    }
}

/// Distance of `p` from the segment from `a` to `b`.
pub(super) fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = dx * dx + dy * dy;
    let t = if length2 > 0.0 {
        (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p.0 - a.0 - t * dx).hypot(p.1 - a.1 - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Rect = Rect {
        left: 0.0,
        top: 0.0,
        right: 1.0,
        bottom: 1.0,
    };

    #[test]
    fn clipping_keeps_the_inside_and_drops_the_rest() {
        assert_eq!(
            UNIT.clip((-1.0, 0.5), (2.0, 0.5)),
            Some(((0.0, 0.5), (1.0, 0.5)))
        );
        assert_eq!(
            UNIT.clip((0.2, 0.2), (0.8, 0.3)),
            Some(((0.2, 0.2), (0.8, 0.3)))
        );
        assert_eq!(UNIT.clip((-1.0, 0.9), (0.1, 2.0)), None);
        assert_eq!(UNIT.clip((2.0, 0.0), (2.0, 1.0)), None);
    }

    #[test]
    fn distance_to_a_segment_includes_its_ends() {
        assert_eq!(distance_to_segment((0.5, 2.0), (0.0, 0.0), (1.0, 0.0)), 2.0);
        assert_eq!(distance_to_segment((4.0, 4.0), (0.0, 0.0), (1.0, 0.0)), 5.0);
        assert_eq!(distance_to_segment((3.0, 4.0), (0.0, 0.0), (0.0, 0.0)), 5.0);
    }
}
