// Writes the renders of each cell.
void main()
{
    uint i = itemOf();
    if (i >= partCount || !isRendered(i))
        return;
    vec4 box = triangles[i].box;
    if (!hasSample(box))
        return;
    Entry entry = Entry(box, triangles[i].x.w, i, parts[i].y >> 2, 0u);
    uvec4 range = findCells(box);
    for (uint y = range.y; y <= range.w; y++)
        for (uint x = range.x; x <= range.z; x++)
        {
            uint at = atomicAdd(cells[y * cellsPerSide + x], 1u);
            if (at < entryCapacity)
                entries[at] = entry;
        }
}
