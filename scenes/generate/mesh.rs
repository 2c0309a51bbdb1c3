//! Triangle meshes: what every part of the scenes is made of.

use glam::{Affine3A, Mat3A, Vec2, Vec3};

/// Vertices and the triangles between them, counter-clockwise from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Where the vertices are, in metres.
    pub positions: Vec<Vec3>,
    /// One unit normal a vertex.
    pub normals: Vec<Vec3>,
    /// One pair of texture coordinates a vertex.
    pub uvs: Vec<Vec2>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Adds a vertex and returns its index.
    pub fn add_vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        (self.positions.len() - 1) as u32
    }

    /// Adds two triangles, cut along the shorter diagonal.
    pub fn add_quad(&mut self, [a, b, c, d]: [u32; 4]) {
        let length = |i: u32, j: u32| self.positions[i as usize].distance_squared(self.positions[j as usize]);
        if length(a, c) <= length(b, d) {
            self.triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            self.triangles.extend([[b, c, d], [b, d, a]]);
        }
    }

    /// Adds all of another mesh.
    pub fn append(&mut self, other: &Mesh) {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.uvs.extend_from_slice(&other.uvs);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// The mesh under a map; one that mirrors turns the triangles round.
    pub fn moved(&self, map: Affine3A) -> Mesh {
        let normals: Mat3A = map.matrix3.inverse().transpose();
        let mirrors = map.matrix3.determinant() < 0.0;
        let turn = |[a, b, c]: [u32; 3]| if mirrors { [a, c, b] } else { [a, b, c] };
        Mesh {
            positions: self.positions.iter().map(|p| map.transform_point3(*p)).collect(),
            normals: self.normals.iter().map(|n| (normals * *n).normalize()).collect(),
            uvs: self.uvs.clone(),
            triangles: self.triangles.iter().map(|t| turn(*t)).collect(),
        }
    }

    /// Twice the area of a triangle along its normal.
    pub fn area_normal(&self, [a, b, c]: [u32; 3]) -> Vec3 {
        let [a, b, c] = [a, b, c].map(|i| self.positions[i as usize]);
        (b - a).cross(c - a)
    }

    /// The triangles whose normals point to the back of their winding.
    pub fn backward_triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.triangles.iter().copied().filter(|t| self.is_backward(*t))
    }

    /// Replaces normals that disagree with the triangles around their vertex by the mean of those.
    pub fn steady_normals(&mut self) {
        const LEAST_COSINE: f32 = 0.6;
        let means = self.mean_normals();
        for (normal, mean) in self.normals.iter_mut().zip(means) {
            if normal.dot(mean) < LEAST_COSINE {
                *normal = mean;
            }
        }
    }

    /// Makes triangles flat whose normals point to the back of their winding.
    pub fn flatten_backward(&mut self) {
        for i in 0..self.triangles.len() {
            let triangle = self.triangles[i];
            if self.is_backward(triangle) {
                let normal = self.area_normal(triangle).normalize();
                self.triangles[i] = triangle.map(|v| {
                    let v = v as usize;
                    self.add_vertex(self.positions[v], normal, self.uvs[v])
                });
            }
        }
    }

    fn is_backward(&self, triangle: [u32; 3]) -> bool {
        let normals = triangle.map(|i| self.normals[i as usize]);
        self.area_normal(triangle).dot(normals.into_iter().sum()) < 0.0
    }

    /// The mean normal of the triangles around each vertex, weighted by their area.
    fn mean_normals(&self) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        for triangle in &self.triangles {
            let normal = self.area_normal(*triangle);
            triangle.iter().for_each(|i| sums[*i as usize] += normal);
        }
        sums.into_iter().map(|sum| sum.normalize_or(Vec3::Y)).collect()
    }
}
