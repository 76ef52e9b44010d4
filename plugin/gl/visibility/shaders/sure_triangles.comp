// The triangle of each part, and how many renders each cell has.
layout(std430, binding = 0) readonly buffer Corners { float corners[]; };

// The plane of a triangle whose orientation is sure.
void findPlane(inout Triangle t, float area)
{
    vec3 u = vec3(t.x.y - t.x.x, t.y.y - t.y.x, t.z.y - t.z.x), v = vec3(t.x.z - t.x.x, t.y.z - t.y.x, t.z.z - t.z.x);
    t.plane.x = (u.z * v.y - v.z * u.y) / area;
    t.plane.y = (v.z * u.x - u.z * v.x) / area;
    float slope = abs(t.plane.x) + abs(t.plane.y);
    float terms = (abs(u.z * v.y) + abs(v.z * u.y) + abs(v.z * u.x) + abs(u.z * v.x)) / abs(area);
    float areaError = 9.5367431640625e-7 * (abs(u.x * v.y) + abs(u.y * v.x)) / abs(area);
    t.z.w = 2.0 * snap * slope + 1.9073486328125e-6 * (1.0 + 2.0 * resolution * terms) + areaError * resolution * slope;
}

Triangle makeTriangle(uint corner)
{
    uint x = (axis + 1u) % 3u, y = (axis + 2u) % 3u;
    Triangle t;
    for (uint i = 0u; i < 3u; i++)
    {
        uint at = corner + 3u * i;
        t.x[i] = (corners[at + x] + 1.0) * (0.5 * resolution);
        t.y[i] = (corners[at + y] + 1.0) * (0.5 * resolution);
        t.z[i] = direction * corners[at + axis];
    }
    // Counted here, and written by another kernel: both find the same cells.
    precise vec4 box = vec4(min(vec2(t.x.x, t.y.x), min(vec2(t.x.y, t.y.y), vec2(t.x.z, t.y.z))) - snap,
                            max(vec2(t.x.x, t.y.x), max(vec2(t.x.y, t.y.y), vec2(t.x.z, t.y.z))) + snap);
    t.box = box;
    float error, area = cross2(vec2(t.x.y - t.x.x, t.y.y - t.y.x), vec2(t.x.z - t.x.x, t.y.z - t.y.x), error);
    t.plane = vec4(0.0, 0.0, area > error ? 1.0 : area < -error ? -1.0 : 0.0, 0.0);
    t.z.w = 1e30;
    if (t.plane.z != 0.0)
        findPlane(t, area);
    t.x.w = min(t.z.x, min(t.z.y, t.z.z)) - t.z.w;
    t.y.w = max(t.z.x, max(t.z.y, t.z.z)) + t.z.w;
    return t;
}

void main()
{
    uint i = itemOf();
    if (i == 0u)
        results[entryCounter] = results[stopCounter] = 0u;
    if (i >= partCount)
        return;
    results[firstResult + i] = 0u;
    Triangle t = makeTriangle(9u * parts[i].x);
    triangles[i] = t;
    if (!isRendered(i) || !hasSample(t.box))
        return;
    uvec4 range = findCells(t.box);
    for (uint y = range.y; y <= range.w; y++)
        for (uint x = range.x; x <= range.z; x++)
            atomicAdd(cells[y * cellsPerSide + x], 1u);
}
