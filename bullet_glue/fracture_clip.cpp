// The face that closes a cut is bounded by the edges that have lost their other triangle: these are found by index, so
// that it closes whatever rounding did to the points. What is left open (loops without area, or that cross themselves)
// is closed by fans.
#include "fracture_face.h"

#include <algorithm>

namespace
{
constexpr size_t s_usualCut = 100; ///< edges that a cut goes through, or fewer

double SideOf(const qcClipPlane& plane, const qcClipPoint& p)
{
    return qcDotOf(plane.normal, p) - plane.distance;
}

//  ---- the cut ---------------------------------------------------------------------------------------

// Where a point is. The sum of three tells where a triangle is.
constexpr uint8_t s_inside = 0, s_onPlane = 1, s_outside = 4;

/// Fills sides and marks of points. Whether any is outside.
bool MarkPoints(const qcClipMesh& mesh, const qcClipPlane& plane, qcClipScratch* scratch)
{
    size_t count = mesh.points.size();
    scratch->sides.resize(count);
    scratch->marks.resize(count);
    uint8_t all = 0;
    for (size_t i = 0; i < count; i++)
    {
        double side = SideOf(plane, mesh.points[i]);
        uint8_t mark = side > 0 ? s_outside : side == 0 ? s_onPlane : s_inside;
        scratch->sides[i] = side;
        scratch->marks[i] = mark;
        all |= mark;
    }
    return (all & s_outside) != 0;
}

/// Where an edge meets the plane. Always from the lower index on: both triangles get one point.
uint32_t Crossing(uint32_t a, uint32_t b, qcClipMesh* mesh, qcClipScratch* scratch)
{
    uint32_t low = std::min(a, b), high = std::max(a, b), made = uint32_t(mesh->points.size());
    uint32_t known = scratch->crossings.FindOrAdd(uint64_t(low) << 32 | high, made);
    if (known != made)
        return known;
    double t = scratch->sides[low] / (scratch->sides[low] - scratch->sides[high]);
    qcClipPoint p;
    for (size_t i = 0; i < 3; i++)
        p[i] = mesh->points[low][i] + t * (mesh->points[high][i] - mesh->points[low][i]);
    mesh->points.push_back(p);
    scratch->marks.push_back(s_onPlane);
    return made;
}

/// Keeps a triangle that is not outside, and counts its edges on the plane.
void Keep(const qcClipTriangle& triangle, qcClipScratch* scratch)
{
    scratch->triangles.push_back(triangle);
    const std::array<uint32_t, 3>& v = triangle.corner;
    const std::vector<uint8_t>& marks = scratch->marks;
    if (marks[v[0]] + marks[v[1]] + marks[v[2]] < 2 * s_onPlane)
        return;
    for (size_t c = 0; c < 3; c++)
        if (marks[v[c]] == s_onPlane && marks[v[(c + 1) % 3]] == s_onPlane)
            scratch->edges.Add(v[c], v[(c + 1) % 3]);
}

/// Keeps what of a triangle is not outside; it is on both sides.
void Split(const qcClipTriangle& triangle, qcClipMesh* mesh, qcClipScratch* scratch)
{
    const std::array<uint32_t, 3>& v = triangle.corner;
    auto isOutside = [&](size_t c) { return scratch->marks[v[c]] == s_outside; };
    int outside = isOutside(0) + isOutside(1) + isOutside(2);
    // From the corner that is alone on its side.
    size_t first = 0;
    while (isOutside(first) != (outside == 1))
        first++;
    uint32_t a = v[first], b = v[(first + 1) % 3], c = v[(first + 2) % 3];
    uint32_t ab = Crossing(a, b, mesh, scratch), ca = Crossing(c, a, mesh, scratch);
    if (outside == 2)
    {
        Keep({{a, ab, ca}, triangle.face}, scratch);
        return;
    }
    Keep({{ab, b, c}, triangle.face}, scratch);
    Keep({{ab, c, ca}, triangle.face}, scratch);
}

//  ---- points ----------------------------------------------------------------------------------------

/// As qcClipMesh_Weld; only points on the plane may be where another is. Points come in the order in which triangles
/// have them, whatever the marks.
void Weld(qcClipMesh* mesh, qcClipScratch* scratch)
{
    constexpr uint32_t none = UINT32_MAX;
    std::vector<qcClipPoint>& points = scratch->points;
    points.resize(mesh->points.size());
    uint32_t count = 0;
    scratch->positions.Clear(s_usualCut);
    scratch->places.assign(mesh->points.size(), none);
    auto findPlace = [&](uint32_t corner)
    {
        const qcClipPoint& point = mesh->points[corner];
        uint32_t place = count;
        if (scratch->marks[corner] == s_onPlane)
            place = scratch->positions.FindOrAdd(point, place);
        if (place == count)
            points[count++] = point;
        return place;
    };
    uint32_t* places = scratch->places.data();
    size_t kept = 0;
    for (const qcClipTriangle& triangle : mesh->triangles)
    {
        uint32_t v[3];
        for (size_t c = 0; c < 3; c++)
        {
            uint32_t corner = triangle.corner[c];
            v[c] = places[corner];
            if (v[c] == none)
                v[c] = places[corner] = findPlace(corner);
        }
        mesh->triangles[kept] = {{v[0], v[1], v[2]}, triangle.face};
        kept += v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
    }
    points.resize(count);
    mesh->triangles.resize(kept);
    mesh->points.swap(points);
}

//  ---- faces made anew -------------------------------------------------------------------------------

/// Triangles by their faces, otherwise in the order of the mesh. All but those that cuts have added are so.
void SortByFace(const qcClipMesh& mesh, qcClipScratch* scratch)
{
    auto isBefore = [](const qcClipTriangle& a, const qcClipTriangle& b) { return a.face < b.face; };
    std::vector<qcClipTriangle>& sorted = scratch->triangles;
    sorted = mesh.triangles;
    auto middle = std::is_sorted_until(sorted.begin(), sorted.end(), isBefore);
    std::stable_sort(middle, sorted.end(), isBefore);
    std::inplace_merge(sorted.begin(), middle, sorted.end(), isBefore);
}

/// Marks points that three faces have, or more. Where there are two, they meet in a line through the point.
void MarkVertices(const qcClipMesh& mesh, qcClipScratch* scratch)
{
    constexpr uint32_t none = UINT32_MAX;
    scratch->faces.assign(mesh.points.size(), {none, none});
    scratch->marks.assign(mesh.points.size(), false);
    for (const qcClipTriangle& triangle : mesh.triangles)
        for (uint32_t corner : triangle.corner)
        {
            std::array<uint32_t, 2>& known = scratch->faces[corner];
            if (known[0] == triangle.face || known[1] == triangle.face)
                continue;
            if (known[0] == none)
                known[0] = triangle.face;
            else if (known[1] == none)
                known[1] = triangle.face;
            else
                scratch->marks[corner] = true;
        }
}

/// The direction that the loops face, by twice their area.
qcClipPoint NormalOf(const qcClipMesh& mesh, const qcClipLoops& loops)
{
    qcClipPoint normal = {0, 0, 0};
    for (size_t loop = 0; loop < loops.ends.size(); loop++)
        for (size_t first = loops.Begin(loop), i = first, end = loops.ends[loop]; i < end; i++)
        {
            const qcClipPoint &from = mesh.points[loops.points[first]], &a = mesh.points[loops.points[i]],
                              &b = mesh.points[loops.points[i + 1 < end ? i + 1 : first]];
            for (size_t k = 0; k < 3; k++)
            {
                size_t u = (k + 1) % 3, v = (k + 2) % 3;
                normal[k] += (a[u] - from[u]) * (b[v] - from[v]) - (a[v] - from[v]) * (b[u] - from[u]);
            }
        }
    return normal;
}

/// Drops the points of loops that are no vertices. A loop may be left with none.
void KeepVertices(const std::vector<uint8_t>& isVertex, qcClipLoops* loops)
{
    size_t kept = 0, i = 0;
    for (size_t& end : loops->ends)
    {
        for (; i < end; i++)
            if (isVertex[loops->points[i]])
                loops->points[kept++] = loops->points[i];
        end = kept;
    }
    loops->points.resize(kept);
}
} // namespace

void qcClipMesh_Weld(qcClipMesh* mesh, qcClipScratch* scratch)
{
    scratch->marks.assign(mesh->points.size(), s_onPlane);
    Weld(mesh, scratch);
}

size_t qcClipMesh_FindOpenTriangle(const qcClipMesh& mesh, qcClipScratch* scratch)
{
    scratch->edges.Clear(mesh.triangles.size() / 2 * 3);
    for (const qcClipTriangle& triangle : mesh.triangles)
        scratch->edges.Add(triangle.corner);
    if (scratch->edges.AreClosed())
        return mesh.triangles.size();
    auto isOpen = [&](const qcClipTriangle& t)
    {
        return !scratch->edges.IsClosed(t.corner[0], t.corner[1]) ||
               !scratch->edges.IsClosed(t.corner[1], t.corner[2]) || !scratch->edges.IsClosed(t.corner[2], t.corner[0]);
    };
    return size_t(std::find_if(mesh.triangles.begin(), mesh.triangles.end(), isOpen) - mesh.triangles.begin());
}

double qcClipMesh_Measure(const qcClipMesh& mesh, qcClipPoint* first)
{
    double volume = 0;
    *first = {0, 0, 0};
    if (mesh.points.empty())
        return 0;
    // Tetrahedra from a point of the mesh: from far away they would cancel.
    const qcClipPoint& from = mesh.points[0];
    for (const qcClipTriangle& triangle : mesh.triangles)
    {
        qcClipPoint e[3];
        for (size_t c = 0; c < 3; c++)
            for (size_t i = 0; i < 3; i++)
                e[c][i] = mesh.points[triangle.corner[c]][i] - from[i];
        double six = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
                     e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                     e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
        volume += six / 6;
        for (size_t i = 0; i < 3; i++)
            (*first)[i] += six / 24 * (e[0][i] + e[1][i] + e[2][i]);
    }
    for (size_t i = 0; i < 3; i++)
        (*first)[i] += volume * from[i];
    return volume;
}

void qcClipMesh_Simplify(qcClipMesh* mesh, qcClipScratch* scratch)
{
    MarkVertices(*mesh, scratch);
    SortByFace(*mesh, scratch);
    const std::vector<uint8_t>& isVertex = scratch->marks;
    const std::vector<qcClipTriangle>& sorted = scratch->triangles;
    qcClipMesh& made = scratch->made;
    made.triangles.clear();
    made.points = mesh->points;
    for (size_t first = 0, end = 0; first < sorted.size(); first = end)
    {
        const qcClipTriangle& triangle = sorted[first];
        const std::array<uint32_t, 3>& v = triangle.corner;
        for (end = first + 1; end < sorted.size() && sorted[end].face == triangle.face;)
            end++;
        // Most are a triangle of the mesh, or a corner of one.
        if (end - first == 1 && isVertex[v[0]] && isVertex[v[1]] && isVertex[v[2]])
        {
            made.triangles.push_back(triangle);
            continue;
        }
        scratch->edges.Clear(3 * (end - first));
        for (size_t i = first; i < end; i++)
            scratch->edges.Add(sorted[i].corner);
        scratch->edges.FindLoops(false, &scratch->loops);
        KeepVertices(isVertex, &scratch->loops);
        qcClipFace_Add(&made, NormalOf(made, scratch->loops), triangle.face, scratch->loops, scratch);
    }
    qcClipMesh_Weld(&made, scratch);
    // Where rounding has bent an outline, splinters do no harm.
    if (qcClipMesh_FindOpenTriangle(made, scratch) == made.triangles.size())
    {
        mesh->points = made.points;
        mesh->triangles = made.triangles;
    }
    mesh->leastTriangles = mesh->triangles.size();
}

void qcClipMesh_Cut(qcClipMesh* mesh, const qcClipPlane& plane, qcClipScratch* scratch)
{
    if (!MarkPoints(*mesh, plane, scratch))
        return;
    scratch->triangles.clear();
    scratch->crossings.Clear(s_usualCut);
    scratch->edges.Clear(s_usualCut);
    for (const qcClipTriangle& triangle : mesh->triangles)
    {
        const std::array<uint32_t, 3>& v = triangle.corner;
        int sum = scratch->marks[v[0]] + scratch->marks[v[1]] + scratch->marks[v[2]];
        if (sum < 2 * s_onPlane)
            scratch->triangles.push_back(triangle);
        else if (sum < s_outside)
            Keep(triangle, scratch);
        else if (sum < 3 * s_outside)
            Split(triangle, mesh, scratch);
    }
    mesh->triangles.swap(scratch->triangles);
    scratch->edges.FindLoops(true, &scratch->loops);
    size_t first = mesh->triangles.size();
    qcClipFace_Add(mesh, plane.normal, plane.face, scratch->loops, scratch);
    // What the face is made of is on the plane, whatever was added.
    scratch->marks.resize(mesh->points.size(), s_onPlane);
    for (size_t i = first; i < mesh->triangles.size(); i++)
        scratch->edges.Add(mesh->triangles[i].corner);
    scratch->edges.FindLoops(true, &scratch->loops);
    qcClipFace_AddFans(mesh, plane.face, scratch->loops);
    // What is off the plane is where it was, and apart from all others as before.
    Weld(mesh, scratch);
    // A cut along a cut goes through its triangles one by one, and the next has more of them.
    mesh->leastTriangles = std::min(mesh->leastTriangles, mesh->triangles.size());
    if (mesh->triangles.size() > mesh->leastTriangles + mesh->leastTriangles / 2)
        qcClipMesh_Simplify(mesh, scratch);
}
