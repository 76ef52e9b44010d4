// The end of the last kernel, of pair_tests or order, which write what the processor reads.
// A copy of the counters, then pairs of triangles: those in no order, then those in order.
layout(std430, binding = 6) writeonly buffer Results { uvec2 outResults[]; };

const uint resultsAt = COUNTER_WORDS / 2u;

shared bool isLast;

// Ends the last kernel. `kernels`: those between it and the first. Its last workgroup copies the counters for the processor.
// They are read by atomics: a cache may hold old ones.
void finish(uint groups, uint k, uint kernels)
{
    memoryBarrier();
    barrier();
    if (k == 0u)
        isLast = atomicAdd(counters[doneCounter], 1u) == groups - 1u;
    barrier();
    if (!isLast)
        return;
    for (uint i = k; i < resultsAt; i += LOCAL_SIZE)
    {
        uvec2 words = uvec2(atomicAdd(counters[2u * i], 0u), atomicAdd(counters[2u * i + 1u], 0u));
        bool allRan = atomicAdd(counters[kernelCounter], 0u) == kernelsOfRun(kernels);
        outResults[i] = uvec2(2u * i == finishedCounter && allRan ? runNumber : words.x, words.y);
    }
}
