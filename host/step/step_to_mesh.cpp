// SPDX-License-Identifier: Apache-2.0
// scribecell-step FILE DEFLECTION_MM: the solids of a STEP file as triangles, in millimetres whatever the file's unit,
// on stdout: lines "v X Y Z", then "t A B C FACE" (corners from 0, counter-clockwise seen from outside). A program of
// its own, so that scribecell runs without Open CASCADE. Exit codes: 0 done; 2 the file cannot be read or holds no
// solid.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <unordered_map>
#include <vector>

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Pnt.hxx>

namespace {

constexpr double kSame = 1e-6;  ///< mm: nodes of neighbouring faces on their shared edge
constexpr double kAngle = 0.2;  ///< radians between neighbouring triangles of a curve

/// Joins nodes at the same place.
class Nodes {
public:
    std::uint32_t add(const gp_Pnt& p) {
        const std::array<double, 3> v{p.X(), p.Y(), p.Z()};
        for (int k = 0; k < 27; ++k) {
            const auto found = cells_.find(key(v, k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
            if (found != cells_.end() && near(places_[found->second], v)) {
                return found->second;
            }
        }
        const auto index = static_cast<std::uint32_t>(places_.size());
        cells_.emplace(key(v, 0, 0, 0), index);
        places_.push_back(v);
        return index;
    }
    void print() const {
        for (const auto& v : places_) {
            std::printf("v %.17g %.17g %.17g\n", v[0], v[1], v[2]);
        }
    }

private:
    static std::uint64_t key(const std::array<double, 3>& v, int dx, int dy, int dz) {
        const auto cell = [](double x, int d) {
            return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / (4.0 * kSame))) + d);
        };
        return (cell(v[0], dx) * 0x9e3779b97f4a7c15ULL) ^ (cell(v[1], dy) * 0xff51afd7ed558ccdULL) ^
               (cell(v[2], dz) * 0xc4ceb9fe1a85ec53ULL);
    }
    static bool near(const std::array<double, 3>& a, const std::array<double, 3>& b) {
        return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) < kSame;
    }

    std::unordered_map<std::uint64_t, std::uint32_t> cells_;
    std::vector<std::array<double, 3>> places_;
};

int fail(const std::string& text) {
    std::fprintf(stderr, "scribecell-step: %s\n", text.c_str());
    return 2;
}

int run(const char* path, double deflection) {
    Message::DefaultMessenger()->ChangePrinters().Clear();  // it would write to stdout
    STEPControl_Reader reader;
    if (reader.ReadFile(path) != IFSelect_RetDone) {
        return fail("is no STEP file that can be read");
    }
    reader.TransferRoots();
    const TopoDS_Shape shape = reader.OneShape();
    if (shape.IsNull() || !TopExp_Explorer(shape, TopAbs_SOLID).More()) {
        return fail("holds no solid, only surfaces or curves: export a closed solid");
    }
    const BRepMesh_IncrementalMesh mesher(shape, deflection, Standard_False, kAngle, Standard_True);
    Nodes nodes;
    std::vector<std::array<std::uint32_t, 4>> triangles;
    std::uint32_t number = 0;
    for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next()) {
        for (TopExp_Explorer faces(solid.Current(), TopAbs_FACE); faces.More(); faces.Next(), ++number) {
            const TopoDS_Face& face = TopoDS::Face(faces.Current());
            TopLoc_Location location;
            const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, location);
            if (mesh.IsNull()) {
                return fail("has a face that cannot be cut into triangles: face " + std::to_string(number + 1));
            }
            std::vector<std::uint32_t> index;
            for (int i = 1; i <= mesh->NbNodes(); ++i) {
                index.push_back(nodes.add(mesh->Node(i).Transformed(location.Transformation())));
            }
            for (int i = 1; i <= mesh->NbTriangles(); ++i) {
                int a = 0;
                int b = 0;
                int c = 0;
                mesh->Triangle(i).Get(a, b, c);
                if (face.Orientation() == TopAbs_REVERSED) {
                    std::swap(b, c);
                }
                const auto at = [&index](int k) { return index[static_cast<std::size_t>(k - 1)]; };
                triangles.push_back({at(a), at(b), at(c), number});
            }
        }
    }
    nodes.print();
    for (const auto& t : triangles) {
        std::printf("t %u %u %u %u\n", t[0], t[1], t[2], t[3]);
    }
    return 0;
}

}  // namespace

#ifdef SC_SANITIZED
/// Open CASCADE keeps its tables until the process ends, which a check for leaks would call one.
extern "C" const char* __asan_default_options() {
    return "detect_leaks=0";
}  // NOLINT(bugprone-reserved-identifier): given
#endif

int main(int argc, char** argv) {
    if (argc != 3 || !(std::atof(argv[2]) > 0.0)) {
        return fail("say: scribecell-step FILE DEFLECTION_MM");
    }
    try {
        return run(argv[1], std::atof(argv[2]));
    } catch (const Standard_Failure& error) {
        return fail(error.GetMessageString());
    } catch (const std::exception& error) {
        return fail(error.what());
    }
}
