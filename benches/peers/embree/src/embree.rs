//! The part of Embree 4's C interface that the race needs, from a library found at run time.
//!
//! The structures follow `rtcore_ray.h` and `rtcore_common.h` of Embree 4. Those that Embree
//! extends with the number of instance levels are given room to spare at their end.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr;
use std::time::Instant;

use libloading::Library;
use sunstone::internals::scene::baked::Triangle;

/// Says of a hit that there is none.
pub const INVALID: u32 = u32::MAX;
const COHERENT: u32 = 1 << 16;
const TYPE_TRIANGLE: c_uint = 0;
const BUFFER_INDEX: c_uint = 0;
const BUFFER_VERTEX: c_uint = 1;
const FORMAT_UINT3: c_uint = 0x5003;
const FORMAT_FLOAT3: c_uint = 0x9003;
const QUALITY_MEDIUM: c_uint = 1;

/// `RTCRay`.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub struct Ray {
    pub origin: [f32; 3],
    pub near: f32,
    pub direction: [f32; 3],
    pub time: f32,
    pub far: f32,
    pub mask: u32,
    pub id: u32,
    pub flags: u32,
}

/// `RTCHit`.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub struct Hit {
    pub normal: [f32; 3],
    pub u: f32,
    pub v: f32,
    pub primitive: u32,
    pub geometry: u32,
    pub instances: [u32; 5],
}

/// `RTCRayHit`.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub struct RayHit {
    pub ray: Ray,
    pub hit: Hit,
}

/// `RTCRayHit16`; its first half is `RTCRay16`.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct RayHit16 {
    pub origin: [[f32; 16]; 3],
    pub near: [f32; 16],
    pub direction: [[f32; 16]; 3],
    pub time: [f32; 16],
    pub far: [f32; 16],
    pub mask: [u32; 16],
    pub id: [u32; 16],
    pub flags: [u32; 16],
    pub normal: [[f32; 16]; 3],
    pub u: [f32; 16],
    pub v: [f32; 16],
    pub primitive: [u32; 16],
    pub geometry: [u32; 16],
    pub instances: [[u32; 16]; 3],
}

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which begin alike.
#[repr(C)]
struct Arguments {
    flags: u32,
    features: u32,
    context: *mut c_void,
    filter: *mut c_void,
    intersect: *mut c_void,
    reserve: [usize; 4],
}

impl Arguments {
    fn new(flags: u32) -> Self {
        Self {
            flags,
            features: u32::MAX,
            context: ptr::null_mut(),
            filter: ptr::null_mut(),
            intersect: ptr::null_mut(),
            reserve: [0; 4],
        }
    }
}

type Query = unsafe extern "C" fn(*mut c_void, *mut c_void, *mut Arguments);
type Query16 = unsafe extern "C" fn(*const c_int, *mut c_void, *mut c_void, *mut Arguments);

/// A committed scene of one triangle mesh, and the functions that trace it.
pub struct Embree {
    scene: *mut c_void,
    intersect1: Query,
    occluded1: Query,
    intersect16: Query16,
    incoherent: Arguments,
    coherent: Arguments,
    /// Seconds that the tree took to build.
    pub build_seconds: f64,
}

impl Embree {
    /// Builds a scene of `triangles` at medium quality with `threads` threads. Scene and device
    /// live until the process ends.
    pub fn new(library: &Path, triangles: &[Triangle], threads: usize) -> Result<Self, String> {
        // SAFETY: the user names the library; the functions are used as Embree 4 declares them,
        // and all buffers are Embree's own.
        unsafe {
            // Never unloaded, as its threads stay.
            let library = Library::new(library).map_err(|error| error.to_string())?;
            let library: &'static Library = Box::leak(Box::new(library));
            let (scene, build_seconds) = commit(library, triangles, threads)
                .map_err(|error| format!("this is not Embree 4: {error}"))?;
            let missing = |error: libloading::Error| format!("this is not Embree 4: {error}");
            Ok(Self {
                scene,
                intersect1: *library.get(b"rtcIntersect1\0").map_err(missing)?,
                occluded1: *library.get(b"rtcOccluded1\0").map_err(missing)?,
                intersect16: *library.get(b"rtcIntersect16\0").map_err(missing)?,
                incoherent: Arguments::new(0),
                coherent: Arguments::new(COHERENT),
                build_seconds,
            })
        }
    }

    /// `rtcIntersect1`.
    #[inline(always)]
    pub fn intersect(&mut self, ray: &mut RayHit) {
        // SAFETY: the scene is committed, and the structures are Embree's.
        unsafe {
            (self.intersect1)(self.scene, ptr::from_mut(ray).cast(), &mut self.incoherent);
        }
    }

    /// `rtcOccluded1`: `far` becomes minus infinity when something is hit.
    #[inline(always)]
    pub fn occluded(&mut self, ray: &mut Ray) {
        // SAFETY: as above.
        unsafe {
            (self.occluded1)(self.scene, ptr::from_mut(ray).cast(), &mut self.incoherent);
        }
    }

    /// `rtcIntersect16` with the coherent flag.
    #[inline(always)]
    pub fn intersect_coherent(&mut self, rays: &mut RayHit16) {
        const VALID: [c_int; 16] = [-1; 16];
        #[repr(align(64))]
        struct Aligned([c_int; 16]);
        static ALL: Aligned = Aligned(VALID);
        // SAFETY: as above.
        unsafe {
            let rays = ptr::from_mut(rays).cast();
            (self.intersect16)(ALL.0.as_ptr(), self.scene, rays, &mut self.coherent);
        }
    }
}

/// Makes the device, the mesh and the scene; the seconds are those of the tree.
unsafe fn commit(
    library: &Library,
    triangles: &[Triangle],
    threads: usize,
) -> Result<(*mut c_void, f64), libloading::Error> {
    type Make = unsafe extern "C" fn(*mut c_void) -> *mut c_void;
    type MakeGeometry = unsafe extern "C" fn(*mut c_void, c_uint) -> *mut c_void;
    type Device = unsafe extern "C" fn(*const c_char) -> *mut c_void;
    type Buffer =
        unsafe extern "C" fn(*mut c_void, c_uint, c_uint, c_uint, usize, usize) -> *mut c_void;
    type Attach = unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_uint;
    type Set = unsafe extern "C" fn(*mut c_void, c_uint);
    type Commit = unsafe extern "C" fn(*mut c_void);
    // SAFETY: the caller vouches for the library; sizes of the buffers are those asked for.
    unsafe {
        let options = format!("threads={threads}\0");
        let device = library.get::<Device>(b"rtcNewDevice\0")?(options.as_ptr().cast());
        let scene = library.get::<Make>(b"rtcNewScene\0")?(device);
        library.get::<Set>(b"rtcSetSceneBuildQuality\0")?(scene, QUALITY_MEDIUM);
        let mesh = library.get::<MakeGeometry>(b"rtcNewGeometry\0")?(device, TYPE_TRIANGLE);
        let buffer = library.get::<Buffer>(b"rtcSetNewGeometryBuffer\0")?;
        let count = triangles.len();
        let corners = buffer(mesh, BUFFER_VERTEX, 0, FORMAT_FLOAT3, 12, 3 * count).cast::<f32>();
        let indices = buffer(mesh, BUFFER_INDEX, 0, FORMAT_UINT3, 12, count).cast::<u32>();
        let all = triangles.iter().flat_map(|t| t.corners).flat_map(|corner| corner.to_array());
        for (index, coordinate) in all.enumerate() {
            corners.add(index).write(coordinate);
        }
        for index in 0..3 * count {
            indices.add(index).write(index as u32);
        }
        library.get::<Commit>(b"rtcCommitGeometry\0")?(mesh);
        library.get::<Attach>(b"rtcAttachGeometry\0")?(scene, mesh);
        let start = Instant::now();
        library.get::<Commit>(b"rtcCommitScene\0")?(scene);
        Ok((scene, start.elapsed().as_secs_f64()))
    }
}
