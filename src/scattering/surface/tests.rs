//! The list of models, and what follows from it.

use super::*;
use crate::scene::baked;

#[test]
fn rows_are_grouped_by_end_specular_and_connecting_kinds() {
    use SurfaceKind::{
        Absorber, Blend, Brushed, Conductor, Dielectric, Diffuse, DispersiveDielectric, Filmed,
        FilmedConductor, FilmedDielectric, Layered, Measured, MetallicRoughness, Plastic,
        RoughConductor, RoughDielectric, ThinDielectric,
    };
    let met: Vec<Met> = SurfaceKind::events().map(|event| event.met).collect();
    let expected = [
        Absorber,
        Conductor,
        Dielectric,
        DispersiveDielectric,
        FilmedConductor,
        FilmedDielectric,
        ThinDielectric,
        Diffuse,
        RoughConductor,
        RoughDielectric,
        MetallicRoughness,
        Layered,
        Plastic,
        Measured,
        Filmed,
        Blend,
        Brushed,
    ];
    assert_eq!(met, expected.map(Met::Surface));
    let sorts: Vec<Sort> = SurfaceKind::MET.iter().map(|kind| kind.sort()).collect();
    assert!(sorts.is_sorted_by_key(|sort| *sort == Sort::Connecting));
}

#[test]
fn every_kind_has_its_event() {
    let events: Vec<Event> = SurfaceKind::events().collect();
    assert_eq!(events.len(), SurfaceKind::EVENTS);
    for &kind in SurfaceKind::ALL {
        let event = events[kind.event()];
        let is_met = kind.is_specular() || kind.connects();
        assert_eq!(event.met == Met::Surface(kind), is_met || kind == SurfaceKind::ALL[END]);
        assert_eq!(event.connects(), kind.connects());
        if kind.is_specular() {
            assert_ne!(event.form, Form::Depolarizer, "{kind:?}");
        }
    }
}

#[test]
fn materials_are_rows_of_the_tables_of_their_models() {
    let glass = SurfaceModel::Dielectric { ior: 1.5, exterior_ior: 1.0 };
    let gray = |reflectance| SurfaceModel::Diffuse { reflectance: [reflectance] };
    let models = [gray(0.5), glass.clone(), gray(0.0), SurfaceModel::Absorber, glass];
    let baked = models.map(|model| baked::Material { model, two_sided: false });
    let surfaces = Surfaces::new(&baked, None);
    let rows: Vec<u32> = surfaces.materials().iter().map(|material| material.row).collect();
    assert_eq!(rows, [0, 0, 1, 0, 1]);
    assert_eq!((surfaces.diffuse().len(), surfaces.dielectric().len()), (2, 2));
    let survival: Vec<f32> = surfaces.materials().iter().map(|it| it.survival).collect();
    assert_eq!(survival, [0.5, 1.0, 0.05, 0.05, 1.0]);
}
