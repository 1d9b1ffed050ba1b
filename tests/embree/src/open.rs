//! How long a large scene takes to open and to come back after an edit.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use mislab_renderer::{Bsdf, Geometry, Picture, Renderer, Request, pbrt};

use crate::mesh;

/// Writes `scene.pbrt` and `mesh.ply` (binary): hills of so many triangles under two lights.
pub fn write(folder: &Path, size: usize) {
    let mesh = mesh::terrain(size);
    let mut ply = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for p in &mesh.positions {
        ply.extend(p.to_array().iter().flat_map(|v| v.to_le_bytes()));
    }
    for t in &mesh.triangles {
        ply.push(3);
        ply.extend(t.iter().flat_map(|v| v.to_le_bytes()));
    }
    let mut text = String::new();
    let (e, t, l) = (mesh.eye, mesh.target, mesh.light);
    writeln!(text, "LookAt {} {} {}  {} {} {}  0 1 0", e.x, e.y, e.z, t.x, t.y, t.z).expect("text can be written");
    text.push_str(
        "Camera \"perspective\" \"float fov\" [55]\n\
         Film \"image\" \"integer xresolution\" [800] \"integer yresolution\" [800]\nWorldBegin\n",
    );
    for (x, radius) in [(l.0.x, l.1), (-l.0.x, 3.0 * l.1)] {
        writeln!(
            text,
            "AttributeBegin\nTranslate {x} {} {}\nAreaLightSource \"area\" \"rgb L\" [200 200 200]\n\
             Shape \"sphere\" \"float radius\" [{radius}]\nAttributeEnd",
            l.0.y, l.0.z
        )
        .expect("text can be written");
    }
    text.push_str(
        "Material \"plastic\" \"rgb Kd\" [0.3 0.3 0.3] \"rgb Ks\" [0.5 0.5 0.5] \"float roughness\" [0.1]\n\
         Shape \"plymesh\" \"string filename\" \"mesh.ply\"\nWorldEnd\n",
    );
    fs::create_dir_all(folder).expect("the folder can be made");
    fs::write(folder.join("mesh.ply"), ply).expect("the mesh can be written");
    fs::write(folder.join("scene.pbrt"), text).expect("the scene can be written");
}

/// Submits a request and waits for its first frame; seconds taken.
fn first_frame(picture: &Picture, request: &Request) -> f64 {
    let start = Instant::now();
    let generation = picture.submit(request.clone());
    let submitted = start.elapsed().as_secs_f64();
    while picture.latest().is_none_or(|frame| frame.generation() != generation) {
        assert!(picture.status().error.is_none(), "{:?}", picture.status());
        std::thread::sleep(std::time::Duration::from_micros(200));
    }
    assert!(submitted < 0.1, "submit took {submitted} s");
    start.elapsed().as_secs_f64()
}

/// Opens a scene as the window does, on two threads, and edits it.
pub fn measure(file: &Path) {
    let start = Instant::now();
    let loaded = pbrt::load(file).expect("the scene can be read");
    let read = start.elapsed().as_secs_f64();
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    let mut request = Request { scene: Arc::new(loaded.scene), settings: loaded.settings };
    request.settings.sampling.spp = None;
    let frame = first_frame(&picture, &request);
    println!("read {read:.2} s, then first frame {frame:.2} s, together {:.2} s", read + frame);

    let mut edit = |name: &str, change: &mut dyn FnMut(&mut Request, u32)| {
        let mut best = f64::INFINITY;
        for i in 1..6 {
            change(&mut request, i);
            best = best.min(first_frame(&picture, &request));
        }
        println!("{name}: frame after {:.0} ms", best * 1e3);
    };
    edit("seed", &mut |r, i| r.settings.sampling.seed = 1000 + i);
    edit("material", &mut |r, i| {
        let scene = Arc::make_mut(&mut r.scene);
        for material in &mut scene.materials {
            if let Bsdf::Plastic { alpha, .. } = &mut material.bsdf {
                *alpha = 0.1 * i as f32;
            }
        }
    });
    edit("light's radius", &mut |r, i| {
        let scene = Arc::make_mut(&mut r.scene);
        let light = scene.light_shapes().next().expect("a light");
        if let Geometry::Sphere { radius, .. } = &mut scene.shapes[light].geometry {
            *radius = 0.1 * i as f32;
        }
    });
    edit("camera", &mut |r, i| Arc::make_mut(&mut r.scene).camera.fov_deg = 50.0 + f64::from(i));
    if let Ok(status) = fs::read_to_string("/proc/self/status") {
        for line in status.lines().filter(|line| line.starts_with("VmHWM") || line.starts_with("VmRSS")) {
            println!("{line}");
        }
    }
}
