// The first entry of each cell.
shared uint sums[64];
shared uint groupFirst;

void main()
{
    uint cell = itemOf(), k = gl_LocalInvocationID.x, cellCount = cellsPerSide * cellsPerSide;
    uint count = cell < cellCount ? cells[cell] : 0u;
    sums[k] = count;
    barrier();
    for (uint distance = 1u; distance < 64u; distance *= 2u)
    {
        uint before = k >= distance ? sums[k - distance] : 0u;
        barrier();
        sums[k] += before;
        barrier();
    }
    // The order of the workgroups' entries does not matter.
    if (k == 63u)
        groupFirst = atomicAdd(results[entryCounter], sums[63]);
    barrier();
    if (cell >= cellCount)
        return;
    cells[cell] = cells[cellCount + cell] = groupFirst + sums[k] - count;
}
