// Layout of a step's data in the stream.
#include "gl/layers/step_data.h"

#include "gl/layers/layers_kernels.h"

#include <string.h>

enum
{
    // Workgroups that compare tiles, where there are few tiles: a GPU of 132 multiprocessors runs half as many at a
    // time.
    qc_comparingGroups = 2048
};

qcStepPlaces qcStepData_FindPlaces(const qcLayersStep* step)
{
    qcStepPlaces p = {.nodes = qc_parameterWords + step->bodyCount * (sizeof(qcLayersBody) / sizeof(uint32_t))};
    p.chunks = p.nodes + step->activeCount;
    p.floats = p.chunks + step->chunkCount * (sizeof(qcLayersChunk) / sizeof(uint32_t));
    p.end = p.floats + step->floatCount;
    return p;
}

size_t qcStepData_ByteCount(const qcLayersStep* step)
{
    return (qcStepData_FindPlaces(step).end - qc_parameterWords) * sizeof(uint32_t) +
           step->vertexCount * sizeof(qcPoint);
}

uint32_t qcStepData_OwnChunkCount(const qcLayersStep* step)
{
    uint32_t count = step->chunkCount;
    for (uint32_t i = 0; i < step->sourceCount; i++)
        count -= step->sources[i].chunkCount;
    return count;
}

static uint32_t TileCount(const qcLayersStep* step)
{
    return (step->activeCount + qc_tileNodes - 1) / qc_tileNodes;
}

/// Workgroups that compare one tile with others: many, so that few wait for one, but no more than pay.
static uint32_t PartsOfTile(uint32_t tiles)
{
    uint32_t min = (tiles + qc_nodeComparers - 1) / qc_nodeComparers, max = tiles;
    uint32_t count = tiles != 0 ? qc_comparingGroups / tiles : 0;
    count = count < max ? count : max;
    return count > min ? count : min;
}

uint64_t qcStepData_ComparingGroupCount(const qcLayersStep* step)
{
    uint32_t tiles = TileCount(step);
    return (uint64_t)tiles * PartsOfTile(tiles);
}

uint32_t qcStepData_ListWords(const qcLayersStep* step, bool imageOnly)
{
    return imageOnly ? 1u << (step->cellsLog2[0] + step->cellsLog2[1] + step->cellsLog2[2])
                     : TileCount(step) * qc_tileWords;
}

uint32_t qcStepData_BucketsAt(const qcLayersStep* step, bool imageOnly)
{
    return qc_counterWords + qcStepData_ListWords(step, imageOnly);
}

void qcStepData_Write(const qcLayersStep* step, const qcLayersStream* stream)
{
    qcStepPlaces p = qcStepData_FindPlaces(step);
    uint32_t* words = (uint32_t*)(void*)qcLayersStream_Data(stream);
    memcpy(words + qc_parameterWords, step->bodies, step->bodyCount * sizeof(qcLayersBody));
    memcpy(words + p.nodes, step->activeNodes, step->activeCount * sizeof(uint32_t));
    if (step->chunkCount != 0)
        memcpy(words + p.chunks, step->chunks, step->chunkCount * sizeof(qcLayersChunk));
}

void qcStepData_WriteParameters(const qcLayersStep* step, const qcLayersLists* lists, const qcLayersBuffers* buffers,
                                uint32_t runNumber, const qcLayersStream* stream)
{
    qcStepPlaces p = qcStepData_FindPlaces(step);
    qcLayersParameters values = {.chunkCount = qcStepData_OwnChunkCount(step),
                                 .changedNodes = step->changedNodes,
                                 .activeNodes = step->activeCount,
                                 .runNumber = runNumber,
                                 .entryCapacity = qcLayersLists_Capacity(lists, qc_listEntries),
                                 .nodePairCapacity = qcLayersLists_Capacity(lists, qc_listNodePairs),
                                 .trianglePairCapacity = qcLayersLists_Capacity(lists, qc_listTrianglePairs),
                                 .survivorCapacity = qcLayersLists_Capacity(lists, qc_listSurvivors),
                                 .listWords = qcStepData_ListWords(step, lists->imageOnly),
                                 .nodesAt = (uint32_t)p.nodes,
                                 .chunksAt = (uint32_t)p.chunks,
                                 .floatsAt = (uint32_t)p.floats,
                                 .nodeBoxesAt = (uint32_t)(qc_boxesOfNode * step->capacity[qc_layersNodes]),
                                 .partsOfTile = PartsOfTile(TileCount(step)),
                                 .nodePairsOfGroup = qcLayersLists_NodePairsOfGroup(lists),
                                 .testNeighbours = step->testNeighbours,
                                 .pointError = step->pointError,
                                 .queryDistance = step->queryDistance,
                                 .unit = step->frame.unit,
                                 .bucketCount = lists->bucketCount,
                                 .bucketShift = lists->bucketShift,
                                 .bucketsAt = qcStepData_BucketsAt(step, lists->imageOnly)};
    values.groupsAt = (uint32_t)(buffers->capacity[qc_workNodeBoxes] / qc_texelsOfImageNode * 4);
    for (int i = 0; i < 3; i++)
    {
        values.cellShift[i] = 15 - step->cellsLog2[i];
        values.axes[i] = (uint32_t)step->frame.axes[i];
        values.origin[i] = step->frame.origin[i];
    }
    memcpy(values.scale, step->scale, sizeof values.scale);
    memcpy(values.slack, step->slack, sizeof values.slack);
    memcpy(qcLayersStream_Data(stream), &values, sizeof values);
}
