// The strongest rival we can write: persistence and MST of a planar cloud on top of CGAL, in one thread.
//
//     g++ -std=c++17 -O3 -march=native -DNDEBUG cgal_pass.cpp -o cgal_pass -lgmp -lmpfr
//     cgal_pass FILE [--repeat N] [--plain]
//
// FILE holds little-endian f64 pairs x, y. The time starts with the points in memory and ends with every dot (birth,
// death, critical edge) and every MST edge in memory. One JSON line is printed: counts, the sum of all persistence, the
// MST length, and seconds per repeat. Scales are radii outside and squared radii inside.
//
// Two things make it fast. The dual union-find needs no boundary matrix. And a face with an obtuse or right angle dies
// when it is born, so it is contracted into the neighbour behind its longest edge before anything is sorted: of a
// random cloud that leaves two thirds of the edges (the Gabriel ones) and half of the faces (the acute ones).
//
// With --plain the second is left out: every finite edge at its alpha value, std::sort, one union-find over all faces.
// This is the dual algorithm as papers give it.

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_2.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using Id = std::uint32_t;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;
using Site = std::pair<Point, Id>;
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<Id, Kernel>;
using Face = CGAL::Triangulation_face_base_with_info_2<Id, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>>;

constexpr Id OUTER = 0;              // every infinite face carries this number, finite ones count from 1
constexpr int ACUTE = 3;             // "no side": the face has no obtuse or right angle
constexpr double ON_DIAGONAL = 1e-12; // persistence below this part of the death is rounding
constexpr double CLEAR = 1e-9;       // persistence above this part of the death is beyond anyone's rounding

struct Edge {
    Id from, to;
};

struct Dot {
    double birth, death;
    Edge critical;
};

struct Skeleton {
    std::vector<Edge> mst;
    std::vector<Dot> dots;
};

// ---------------------------------------------------------------------------------------------- triangulation

struct Triangulation {
    std::vector<Site> sites; // in spatial order, so that what is near in the plane is near in memory
    Delaunay delaunay;       // the info of a vertex is the place of its site in that order
};

Triangulation triangulate(const std::vector<Point>& points) {
    Triangulation made;
    made.sites.reserve(points.size());
    for (Id id = 0; id < points.size(); ++id) made.sites.emplace_back(points[id], id);

    // Sorting whole sites instead of indices keeps the sort and the insertion in cache.
    using Coordinates = CGAL::First_of_pair_property_map<Site>;
    const CGAL::Spatial_sort_traits_adapter_2<Kernel, Coordinates> traits;
    CGAL::spatial_sort(made.sites.begin(), made.sites.end(), traits);

    Delaunay::Face_handle hint;
    for (Id place = 0; place < made.sites.size(); ++place) {
        const auto vertex = made.delaunay.insert(made.sites[place].first, hint);
        vertex->info() = place;
        hint = vertex->face();
    }
    return made;
}

// ---------------------------------------------------------------------------------------------------- filtration

// Side i of a face is opposite its corner i. It has 28 bytes: at a million points memory is the bottleneck.
struct FlatFace {
    std::array<Id, 3> corners; // places of sites
    std::array<Id, 3> neighbours;
    int widest; // the side opposite an obtuse or right angle, or ACUTE
};

// The sign of (p - q).(r - q) <= 0. It is exact, since slivers must not turn the contraction into a cycle.
bool obtuse_or_right(const Point& p, const Point& q, const Point& r) {
    const double along_x = (p.x() - q.x()) * (r.x() - q.x()), along_y = (p.y() - q.y()) * (r.y() - q.y());
    const double dot = along_x + along_y;
    const double doubt = 8 * std::numeric_limits<double>::epsilon() * (std::abs(along_x) + std::abs(along_y));
    if (std::abs(dot) > doubt) return dot < 0;
    return CGAL::angle(p, q, r) != CGAL::ACUTE;
}

int widest_side(const Point& a, const Point& b, const Point& c) {
    const bool at_a = obtuse_or_right(b, a, c), at_b = obtuse_or_right(c, b, a), at_c = obtuse_or_right(a, c, b);
    return at_a ? 0 : at_b ? 1 : at_c ? 2 : ACUTE;
}

// CGAL's faces are nodes with pointers: one pass numbers and measures them, one more reads the neighbours' numbers.
std::vector<FlatFace> flatten(Delaunay& delaunay) {
    std::vector<FlatFace> faces{{{}, {}, ACUTE}}; // the outer face
    faces.reserve(1 + delaunay.number_of_faces());
    for (auto face : delaunay.all_face_handles()) face->info() = OUTER;
    for (auto face : delaunay.finite_face_handles()) {
        const auto a = face->vertex(0), b = face->vertex(1), c = face->vertex(2);
        face->info() = static_cast<Id>(faces.size());
        faces.push_back({{a->info(), b->info(), c->info()}, {}, widest_side(a->point(), b->point(), c->point())});
    }
    for (auto face : delaunay.finite_face_handles())
        for (int i = 0; i < 3; ++i) faces[face->info()].neighbours[i] = face->neighbor(i)->info();
    return faces;
}

// ---------------------------------------------------------------------------------------------------- contraction

// The target of each face: the neighbour behind its attached side, whose circumradius is no smaller. An acute face and
// the outer face stay. Two right angles that face each other over a common diameter would swap, so the first one stays.
std::vector<Id> flow(const std::vector<FlatFace>& faces) {
    std::vector<Id> into(faces.size());
    for (Id f = 0; f < faces.size(); ++f)
        into[f] = faces[f].widest == ACUTE ? f : faces[f].neighbours[faces[f].widest];
    for (Id f = 0; f < faces.size(); ++f)
        if (into[f] > f && into[into[f]] == f) into[f] = f;
    return into;
}

template <class Links>
Id find(Links& parent, Id node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]]; // path halving
    return node;
}

// The remaining dual graph: its nodes are the faces that stay, weighted by squared circumradius.
struct Dual {
    struct Link {
        Id one, other; // nodes
        Edge edge;
    };
    struct Key {
        std::uint64_t descending; // bits of the squared length, flipped: the longest edge first
        Id link;
    };
    std::vector<double> weight;
    std::vector<Link> links;
    std::vector<Key> order;
};

std::uint64_t descending(double length) {
    std::uint64_t bits;
    std::memcpy(&bits, &length, sizeof bits); // bits of non-negative doubles sort like their values
    return ~bits;
}

double length_of(std::uint64_t descending) {
    const std::uint64_t bits = ~descending;
    double length;
    std::memcpy(&length, &bits, sizeof length);
    return length;
}

double squared_circumradius(const FlatFace& face, const std::vector<Site>& sites) {
    const auto [a, b, c] = face.corners;
    return CGAL::squared_radius(sites[a].first, sites[b].first, sites[c].first);
}

// The node of every face. Nodes are numbered in face order, so that neighbours in the plane are close in memory.
std::vector<Id> contract(const std::vector<FlatFace>& faces, const std::vector<Site>& sites,
                         const std::vector<Id>& into, Dual& dual) {
    std::vector<Id> root = into, node(faces.size());
    dual.weight.push_back(std::numeric_limits<double>::infinity()); // the outer face
    for (Id f = 1; f < faces.size(); ++f) {
        if (into[f] != f) continue;
        node[f] = static_cast<Id>(dual.weight.size());
        dual.weight.push_back(squared_circumradius(faces[f], sites));
    }
    for (Id f = 0; f < faces.size(); ++f) node[f] = node[find(root, f)];
    return node;
}

// Attached sides are done. A Gabriel edge inside one node closes a loop of larger ones, so it is in the MST.
Dual reduce(const std::vector<FlatFace>& faces, const std::vector<Site>& sites, std::vector<Edge>& mst) {
    Dual dual;
    const std::vector<Id> into = flow(faces), node = contract(faces, sites, into, dual);
    dual.links.reserve(faces.size());
    dual.order.reserve(faces.size());
    for (Id f = 1; f < faces.size(); ++f) {
        for (int i = 0; i < 3; ++i) {
            const FlatFace& face = faces[f];
            const Id g = face.neighbours[i];
            if (g > f || i == face.widest || into[g] == f) continue;
            const auto& [here, from] = sites[face.corners[(i + 1) % 3]];
            const auto& [there, to] = sites[face.corners[(i + 2) % 3]];
            const Edge edge{from, to};
            if (node[f] == node[g]) {
                mst.push_back(edge);
                continue;
            }
            dual.order.push_back({descending(CGAL::squared_distance(here, there)), static_cast<Id>(dual.links.size())});
            dual.links.push_back({node[f], node[g], edge});
        }
    }
    return dual;
}

// ---------------------------------------------------------------------------------------------------------- sorting

// Radix passes over the upper half of the keys. The few runs of equal halves are sorted by comparison.
void sort_by_key(std::vector<Dual::Key>& keys) {
    constexpr int DIGIT = 11, SIZE = 1 << DIGIT;
    constexpr std::array<int, 3> SHIFTS{31, 42, 53};
    std::vector<Dual::Key> spare(keys.size());
    for (const int shift : SHIFTS) {
        std::array<std::size_t, SIZE> start{};
        for (const auto& key : keys) ++start[(key.descending >> shift) & (SIZE - 1)];
        std::size_t sum = 0;
        for (auto& slot : start) sum += std::exchange(slot, sum);
        for (const auto& key : keys) spare[start[(key.descending >> shift) & (SIZE - 1)]++] = key;
        keys.swap(spare);
    }
    for (auto run = keys.begin(); run != keys.end();) {
        const auto end = std::find_if(run, keys.end(), [&](const Dual::Key& key) {
            return key.descending >> SHIFTS[0] != run->descending >> SHIFTS[0];
        });
        if (end - run > 1)
            std::sort(run, end, [](const Dual::Key& a, const Dual::Key& b) { return a.descending < b.descending; });
        run = end;
    }
}

// ------------------------------------------------------------------------------------------------------- elder rule

void add_dot(std::vector<Dot>& dots, double squared_length, double squared_death, Edge critical) {
    const double birth = std::sqrt(squared_length) / 2, death = std::sqrt(squared_death);
    if (death - birth > ON_DIAGONAL * death) dots.push_back({birth, death, critical});
}

// From the longest edge down: an edge between two components ends the younger one (the smaller maximum) and is the
// critical edge of its dot. An edge inside a component is in the MST. The root of a component is its maximum.
void sweep(const Dual& dual, Skeleton& skeleton) {
    constexpr std::size_t AHEAD = 16;
    std::vector<Id> parent(dual.weight.size());
    for (Id node = 0; node < parent.size(); ++node) parent[node] = node;
    skeleton.dots.reserve(dual.weight.size());
    for (std::size_t i = 0; i < dual.order.size(); ++i) {
        if (i + 2 * AHEAD < dual.order.size()) __builtin_prefetch(&dual.links[dual.order[i + 2 * AHEAD].link]);
        if (i + AHEAD < dual.order.size()) {
            const auto& soon = dual.links[dual.order[i + AHEAD].link];
            __builtin_prefetch(&parent[soon.one]);
            __builtin_prefetch(&parent[soon.other]);
        }
        const auto& link = dual.links[dual.order[i].link];
        Id elder = find(parent, link.one), younger = find(parent, link.other);
        if (elder == younger) {
            skeleton.mst.push_back(link.edge);
            continue;
        }
        if (dual.weight[elder] < dual.weight[younger]) std::swap(elder, younger);
        parent[younger] = elder;
        add_dot(skeleton.dots, length_of(dual.order[i].descending), dual.weight[younger], link.edge);
    }
}

// The dual graph without contraction: all faces, all edges with the scale at which they enter.
Dual uncontracted(const std::vector<FlatFace>& faces, const std::vector<Site>& sites) {
    Dual dual;
    dual.weight.assign(faces.size(), std::numeric_limits<double>::infinity());
    for (Id f = 1; f < faces.size(); ++f) dual.weight[f] = squared_circumradius(faces[f], sites);
    dual.links.reserve(faces.size() / 2 * 3);
    dual.order.reserve(faces.size() / 2 * 3);
    for (Id f = 1; f < faces.size(); ++f) {
        for (int i = 0; i < 3; ++i) {
            const FlatFace& face = faces[f];
            const Id g = face.neighbours[i];
            if (g > f) continue;
            const auto& [here, from] = sites[face.corners[(i + 1) % 3]];
            const auto& [there, to] = sites[face.corners[(i + 2) % 3]];
            const auto& across = faces[g];
            const bool attached = i == face.widest || (across.widest != ACUTE && across.neighbours[across.widest] == f);
            const double length = attached ? 4 * std::min(dual.weight[f], dual.weight[g]) : CGAL::squared_distance(here, there);
            dual.order.push_back({descending(length), static_cast<Id>(dual.links.size())});
            dual.links.push_back({f, g, {from, to}});
        }
    }
    return dual;
}

Skeleton persistence(Triangulation& triangulation, bool plain) {
    auto& [sites, delaunay] = triangulation;
    Skeleton skeleton;
    if (delaunay.number_of_vertices() > 0) skeleton.mst.reserve(delaunay.number_of_vertices() - 1);
    if (delaunay.dimension() < 2) { // all on one line: the path is the MST and there is no hole
        for (const auto& [face, i] : delaunay.finite_edges())
            skeleton.mst.push_back({sites[face->vertex(0)->info()].second, sites[face->vertex(1)->info()].second});
        return skeleton;
    }
    const std::vector<FlatFace> faces = flatten(delaunay);
    Dual dual = plain ? uncontracted(faces, sites) : reduce(faces, sites, skeleton.mst);
    if (plain) std::sort(dual.order.begin(), dual.order.end(), [](const auto& a, const auto& b) { return a.descending < b.descending; });
    else sort_by_key(dual.order);
    sweep(dual, skeleton);
    if (skeleton.mst.size() + 1 != delaunay.number_of_vertices()) throw std::logic_error("the MST does not span");
    return skeleton;
}

// ---------------------------------------------------------------------------------------------------------- program

struct Arguments {
    std::string file;
    int repeat = 1;
    bool plain = false;
};

Arguments parse(int count, char** values) {
    Arguments arguments;
    for (int i = 1; i < count; ++i) {
        const std::string value = values[i];
        if (value == "--repeat" && i + 1 < count) arguments.repeat = std::atoi(values[++i]);
        else if (value == "--plain") arguments.plain = true;
        else if (arguments.file.empty() && value[0] != '-') arguments.file = value;
        else throw std::invalid_argument("unexpected argument " + value);
    }
    if (arguments.file.empty() || arguments.repeat < 1)
        throw std::invalid_argument("usage: cgal_pass FILE [--repeat N] [--plain]");
    return arguments;
}

std::vector<Point> read(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) throw std::runtime_error("cannot read " + path);
    std::vector<std::array<double, 2>> pairs(static_cast<std::size_t>(file.tellg()) / sizeof(std::array<double, 2>));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(pairs.data()), static_cast<std::streamsize>(pairs.size() * sizeof pairs[0]));
    std::vector<Point> points;
    points.reserve(pairs.size());
    for (const auto& [x, y] : pairs) points.emplace_back(x, y);
    return points;
}

struct Times {
    std::vector<double> total, triangulation, rest;
};

Skeleton timed_pass(const std::vector<Point>& points, bool plain, Times& times) {
    using Clock = std::chrono::steady_clock;
    using Seconds = std::chrono::duration<double>;
    const auto start = Clock::now();
    Triangulation triangulation = triangulate(points);
    const auto triangulated = Clock::now();
    Skeleton skeleton = persistence(triangulation, plain);
    const auto end = Clock::now();
    times.total.push_back(Seconds(end - start).count());
    times.triangulation.push_back(Seconds(triangulated - start).count());
    times.rest.push_back(Seconds(end - triangulated).count());
    return skeleton;
}

// getrusage is not used: its maximum starts from that of the parent process.
long long peak_rss_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind("VmHWM:", 0) == 0) return 1024LL * std::atoll(line.c_str() + std::strlen("VmHWM:"));
    return 0;
}

std::string json(const std::vector<double>& seconds) {
    std::string text;
    for (const double value : seconds) text += (text.empty() ? "" : ",") + std::to_string(value);
    return "[" + text + "]";
}

void report(const std::vector<Point>& points, const Skeleton& skeleton, const Times& times, long long peak) {
    double mst_length = 0, persistence_sum = 0;
    for (const auto [from, to] : skeleton.mst)
        mst_length += std::sqrt(CGAL::squared_distance(points[from], points[to]));
    std::size_t clear_dots = 0;
    for (const Dot& dot : skeleton.dots) {
        persistence_sum += dot.death - dot.birth;
        clear_dots += dot.death - dot.birth > CLEAR * dot.death;
    }
    std::printf("{\"points\":%zu,\"dots\":%zu,\"clear_dots\":%zu,\"persistence_sum\":%.17g,\"mst_length\":%.17g,"
                "\"seconds\":%s,\"triangulation_seconds\":%s,\"rest_seconds\":%s,\"peak_rss_bytes\":%lld}\n",
                points.size(), skeleton.dots.size(), clear_dots, persistence_sum, mst_length,
                json(times.total).c_str(), json(times.triangulation).c_str(), json(times.rest).c_str(), peak);
}

} // namespace

int main(int count, char** values) try {
    const Arguments arguments = parse(count, values);
    const std::vector<Point> points = read(arguments.file);
    Times times;
    Skeleton skeleton;
    for (int i = 0; i < arguments.repeat; ++i) {
        skeleton = {}; // before the next pass, or the peak would count it twice
        skeleton = timed_pass(points, arguments.plain, times);
    }
    report(points, skeleton, times, peak_rss_bytes());
} catch (const std::exception& error) {
    std::fprintf(stderr, "cgal_pass: %s\n", error.what());
    return 2;
}
